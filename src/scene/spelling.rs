//! The word that was probably meant.

/// Longest word that is compared, in characters: a longer one is no slip of the pen.
const LONGEST: usize = 64;

/// The nearest of `words` to `wrong`, when it is near enough to have been meant: at most a third of its letters differ.
#[must_use]
pub fn nearest<'a>(wrong: &str, words: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wrong: Vec<char> = wrong.chars().take(LONGEST + 1).flat_map(char::to_lowercase).collect();
    let allowed = (wrong.len() / 3).max(1);
    let ranked =
        words.into_iter().map(|word| (distance(&wrong, &word.to_lowercase().chars().collect::<Vec<_>>()), word));
    let (distance, word) = ranked.min_by_key(|(distance, _)| *distance)?;
    (wrong.len() <= LONGEST && distance <= allowed && distance < wrong.len()).then_some(word)
}

/// Letters to insert, remove, replace or swap with their neighbour (Damerau 1964, optimal string alignment).
fn distance(a: &[char], b: &[char]) -> usize {
    let mut earlier: Vec<usize> = Vec::new();
    let mut above: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let replaced = above[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = replaced.min(above[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(earlier[j - 2] + 1);
            }
            row.push(best);
        }
        earlier = std::mem::replace(&mut above, row);
    }
    above[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apart(a: &str, b: &str) -> usize {
        distance(&a.chars().collect::<Vec<_>>(), &b.chars().collect::<Vec<_>>())
    }

    #[test]
    fn distances_of_known_pairs() {
        assert_eq!(apart("kitten", "sitting"), 3);
        assert_eq!(apart("humidty", "humidity"), 1);
        assert_eq!(apart("sede", "seed"), 1);
        assert_eq!(apart("", "ab"), 2);
    }

    #[test]
    fn only_near_words_are_offered() {
        let words = ["width", "height", "samples"];
        assert_eq!(nearest("widht", words), Some("width"));
        assert_eq!(nearest("WIDTH", words), Some("width"));
        assert_eq!(nearest("colour", words), None);
        assert_eq!(nearest(&"w".repeat(1_000_000), words), None);
        assert_eq!(nearest("x", []), None);
    }
}
