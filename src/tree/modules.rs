//! A string of modules: the letters with their identities and parameters.

/// One module of the string.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Module {
    /// The letter or sign, ASCII.
    pub letter: u8,
    /// Stable identity.
    pub id: u64,
    /// The derivation step that wrote it; 0 for the axiom.
    pub birth: u32,
    /// How many parameters it has.
    count: u8,
    /// Its first parameter.
    argument: f64,
    /// Where its parameters start in [`Modules::values`], if there are several.
    first: usize,
}

impl Module {
    /// How many parameters it has.
    pub fn count(&self) -> usize {
        usize::from(self.count)
    }

    /// The first parameter, if it has any.
    pub fn argument(&self) -> Option<f64> {
        (self.count > 0).then_some(self.argument)
    }
}

/// A string of modules. Those with several parameters have them in an arena of its own, so that a module that stays is copied
/// without them; what modules that are gone have left there is swept out when it is more than what is used.
#[derive(Clone, Debug, Default)]
pub(super) struct Modules {
    pub list: Vec<Module>,
    values: Vec<f64>,
    /// Length of `values` after they were last swept.
    swept: usize,
}

impl Modules {
    pub fn parameters<'a>(&'a self, module: &'a Module) -> &'a [f64] {
        match module.count {
            0 => &[],
            1 => std::slice::from_ref(&module.argument),
            count => &self.values[module.first..][..usize::from(count)],
        }
    }

    pub fn count(&self, letter: u8) -> usize {
        self.list.iter().filter(|module| module.letter == letter).count()
    }

    /// Bytes of a string of `length` modules and its parameters.
    pub fn bytes(&self, length: usize) -> usize {
        length * size_of::<Module>() + self.values.len() * size_of::<f64>()
    }

    /// Adds a module; its parameters are in `parameters`.
    pub fn push(&mut self, letter: u8, id: u64, birth: u32, parameters: &[f64]) {
        let (first, argument) = (self.values.len(), parameters.first().copied().unwrap_or(0.0));
        if parameters.len() > 1 {
            self.values.extend_from_slice(parameters);
        }
        self.list.push(Module { letter, id, birth, count: parameters.len() as u8, argument, first });
    }

    /// Keeps only the modules marked.
    pub fn retain(&mut self, kept: &[bool]) {
        let mut marks = kept.iter();
        self.list.retain(|_| marks.next() == Some(&true));
    }

    /// Gives back the room of parameters that no module has any more, when that pays.
    pub fn sweep(&mut self) {
        if self.values.len() < 3 * self.swept + 4096 {
            return;
        }
        let several = |module: &&mut Module| module.count > 1;
        let used: usize = self.list.iter_mut().filter(several).map(|module| usize::from(module.count)).sum();
        let mut swept = Vec::with_capacity(used);
        for module in self.list.iter_mut().filter(several) {
            let first = swept.len();
            swept.extend_from_slice(&self.values[module.first..][..usize::from(module.count)]);
            module.first = first;
        }
        (self.values, self.swept) = (swept, used);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sweeping_keeps_letters_and_parameters() {
        let mut modules = Modules::default();
        for number in 0..5000u32 {
            let parameters = [f64::from(number), -f64::from(number)];
            modules.push(b'A' + (number % 26) as u8, u64::from(number), 1, &parameters);
        }
        let kept: Vec<bool> = (0..5000).map(|number| number % 7 == 3).collect();
        modules.retain(&kept);
        let seen = |modules: &Modules| {
            let module = |module: &Module| (module.letter, module.id, modules.parameters(module).to_vec());
            modules.list.iter().map(module).collect::<Vec<_>>()
        };
        let (before, bytes) = (seen(&modules), modules.bytes(0));
        modules.sweep();
        assert_eq!((seen(&modules), modules.bytes(0)), (before.clone(), before.len() * 16));
        assert!(bytes > modules.bytes(0));
        assert_eq!(before[1], (b'A' + 10, 10, vec![10.0, -10.0]));
    }
}
