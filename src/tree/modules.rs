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
    /// Where they start in [`Modules::values`].
    first: usize,
}

/// A string of modules. Parameters stand in an arena of their own, so that a module that stays is copied without them; what
/// modules that are gone have left there is swept out when it is more than what is used.
#[derive(Clone, Debug, Default)]
pub(super) struct Modules {
    pub list: Vec<Module>,
    values: Vec<f64>,
}

impl Modules {
    pub fn parameters(&self, module: &Module) -> &[f64] {
        &self.values[module.first..][..usize::from(module.count)]
    }

    pub fn count(&self, letter: u8) -> usize {
        self.list.iter().filter(|module| module.letter == letter).count()
    }

    /// Bytes of a string of `length` modules and its parameters.
    pub fn bytes(&self, length: usize) -> usize {
        length * size_of::<Module>() + self.values.len() * size_of::<f64>()
    }

    /// Adds a parameter for the module that is added next.
    pub fn push_parameter(&mut self, value: f64) {
        self.values.push(value);
    }

    /// Adds a module whose `count` parameters were added just before.
    pub fn push(&mut self, letter: u8, id: u64, birth: u32, count: usize) {
        self.list.push(Module { letter, id, birth, count: count as u8, first: self.values.len() - count });
    }

    /// Keeps only the modules marked.
    pub fn retain(&mut self, kept: &[bool]) {
        let mut marks = kept.iter();
        self.list.retain(|_| marks.next() == Some(&true));
    }

    /// Gives back the room of parameters that no module has any more, when that pays.
    pub fn sweep(&mut self) {
        let used: usize = self.list.iter().map(|module| usize::from(module.count)).sum();
        if self.values.len() < 2 * used + 1024 {
            return;
        }
        let mut swept = Vec::with_capacity(used);
        for module in &mut self.list {
            let first = swept.len();
            swept.extend_from_slice(&self.values[module.first..][..usize::from(module.count)]);
            module.first = first;
        }
        self.values = swept;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sweeping_keeps_letters_and_parameters() {
        let mut modules = Modules::default();
        for number in 0..5000u32 {
            modules.push_parameter(f64::from(number));
            modules.push_parameter(-f64::from(number));
            modules.push(b'A' + (number % 26) as u8, u64::from(number), 1, 2);
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
