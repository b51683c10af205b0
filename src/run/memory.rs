//! How much memory this process may take, as the system tells before any is taken. An allocation that fails ends a Rust
//! program without a message of ours, so what is predicted is held against this first; it decides no byte of an output.
//!
//! Read from /proc and the control groups of Linux; where they are not there, nothing is known and nothing is bounded.

use std::fs;
use std::path::{Path, PathBuf};

/// Share of the machine's memory that a run takes unless the operator allows more.
const SHARE: f64 = 0.75;
/// Address space that a thread takes beside what is allocated: 2 MiB of stack and the 64 MiB that glibc's allocator
/// reserves for each of its arenas (malloc/arena.c, `HEAP_MAX_SIZE`), once more for those of the main thread.
const THREAD: f64 = 66.0 * 1024.0 * 1024.0;

/// Bytes that this process may take with so many threads: the least of its address space, its control groups and three
/// quarters of the machine's memory. Infinite when nothing is known.
#[must_use]
pub fn available(threads: usize) -> f64 {
    let read = |path: &str| fs::read_to_string(path).unwrap_or_default();
    let space = address_space(&read("/proc/self/limits")) - THREAD * threads as f64;
    let machine = total(&read("/proc/meminfo")) * SHARE;
    let groups = group_files(&read("/proc/self/cgroup"));
    let groups = groups.iter().map(|path| group(&fs::read_to_string(path).unwrap_or_default()));
    groups.fold(space.min(machine), f64::min).max(0.0)
}

/// How many threads may be started of those that are `wanted`: where the address space is bounded they get a quarter of it.
/// Fewer threads are slower and change nothing else.
#[must_use]
pub fn threads(wanted: usize) -> usize {
    threads_within(wanted, address_space(&fs::read_to_string("/proc/self/limits").unwrap_or_default()))
}

fn threads_within(wanted: usize, space: f64) -> usize {
    // The cast saturates where the address space is not bounded.
    wanted.min((space / (4.0 * THREAD)) as usize).max(1)
}

/// Whether the system would give this process so many more bytes at once. They are reserved and given back, not used.
#[must_use]
pub fn is_granted(bytes: f64) -> bool {
    // Beyond any address space the cast saturates, and the reservation fails as it should.
    Vec::<u8>::new().try_reserve_exact(bytes as usize).is_ok()
}

/// The soft limit of the address space from /proc/self/limits.
fn address_space(text: &str) -> f64 {
    let line = text.lines().find_map(|line| line.strip_prefix("Max address space"));
    first_number(line)
}

/// `MemTotal` of /proc/meminfo, in kibibytes there.
fn total(text: &str) -> f64 {
    first_number(text.lines().find_map(|line| line.strip_prefix("MemTotal:"))) * 1024.0
}

/// The content of a control group's limit; version 2 writes `max` for none, version 1 a number near 2^63.
fn group(text: &str) -> f64 {
    first_number(Some(text))
}

fn first_number(text: Option<&str>) -> f64 {
    let word = text.and_then(|text| text.split_whitespace().next());
    word.and_then(|word| word.parse::<u64>().ok()).map_or(f64::INFINITY, |number| number as f64)
}

/// The files that may hold a limit of this process, from /proc/self/cgroup: those of its groups and all around them, of
/// both versions. In a container the path is often not mounted, but the container's own group is at the root.
fn group_files(text: &str) -> Vec<PathBuf> {
    let of_line = |line: &str| {
        let mut fields = line.splitn(3, ':').skip(1);
        let (controllers, path) = (fields.next()?, fields.next()?);
        let (root, name) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max"),
            _ if controllers.split(',').any(|one| one == "memory") => {
                ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")
            }
            _ => return None,
        };
        let inner = Path::new(path.trim_start_matches('/'));
        Some(inner.ancestors().map(|group| Path::new(root).join(group).join(name)).collect::<Vec<PathBuf>>())
    };
    text.lines().filter_map(of_line).flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_as_linux_writes_them() {
        let limits = "Limit                     Soft Limit           Hard Limit           Units     \n\
                      Max resident set          unlimited            unlimited            bytes     \n\
                      Max address space         536870912            unlimited            bytes     \n";
        assert_eq!(address_space(limits), 536_870_912.0);
        assert_eq!(
            address_space("Max address space         unlimited            unlimited            bytes"),
            f64::INFINITY
        );
        assert_eq!(total("MemTotal:       24683412 kB\nMemFree: 1 kB\n"), 24_683_412.0 * 1024.0);
        assert_eq!((group("max\n"), group("1073741824\n"), group("")), (f64::INFINITY, 1_073_741_824.0, f64::INFINITY));
    }

    #[test]
    fn every_group_around_the_process_is_asked() {
        let files = group_files("4:memory:/a/b\n3:cpuset:/\n0::/c\n");
        let expected = [
            "/sys/fs/cgroup/memory/a/b/memory.limit_in_bytes",
            "/sys/fs/cgroup/memory/a/memory.limit_in_bytes",
            "/sys/fs/cgroup/memory/memory.limit_in_bytes",
            "/sys/fs/cgroup/c/memory.max",
            "/sys/fs/cgroup/memory.max",
        ];
        assert_eq!(files, expected.map(PathBuf::from));
        assert!(group_files("nonsense\n:\n").is_empty());
    }

    #[test]
    fn threads_leave_room_for_the_work() {
        assert_eq!(threads_within(8, 512.0 * 1024.0 * 1024.0), 1);
        assert_eq!(threads_within(8, 4096.0 * 1024.0 * 1024.0), 8);
        assert_eq!((threads_within(1000, f64::INFINITY), threads_within(4, 1e6)), (1000, 1));
    }

    #[test]
    fn a_little_is_granted_and_more_than_any_address_space_is_not() {
        assert!(is_granted(1e6));
        assert!(!is_granted(1e19));
        assert!(available(1) > 0.0);
    }
}
