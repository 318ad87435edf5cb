//! `--partition`: the share of the units that one of several machines runs.

use std::str::FromStr;

use sha2::{Digest, Sha256};

use numbers::random::digest_bits;

/// Share `part` of `of`, counted from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Partition {
    by: By,
    part: usize,
    of: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum By {
    /// In turn, in the order of the units.
    Slice,
    /// By the unit's key alone.
    Hash,
}

impl Partition {
    /// Whether the unit with this key, which stands at `place` (from 0) among those selected, belongs to it.
    pub fn holds(self, place: usize, key: &str) -> bool {
        let number = match self.by {
            By::Slice => place as u64,
            By::Hash => hash(key),
        };
        number % self.of as u64 == self.part as u64 - 1
    }
}

/// The first eight bytes of the key's SHA-256, as a little-endian number. Never to be changed: machines with different
/// versions must agree on the shares.
fn hash(key: &str) -> u64 {
    digest_bits(Sha256::new().chain_update(key))
}

impl FromStr for Partition {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("`{text}` is no partition; write it like slice:1/4 or hash:1/4");
        let (by, share) = text.split_once(':').ok_or_else(expected)?;
        let by = match by {
            "slice" => By::Slice,
            "hash" => By::Hash,
            _ => return Err(expected()),
        };
        let (part, of) = share.split_once('/').ok_or_else(expected)?;
        let number = |text: &str| text.parse::<usize>().map_err(|_| expected());
        let (part, of) = (number(part)?, number(of)?);
        if part == 0 || part > of {
            return Err(format!("there is no share {part} of {of}; shares count from 1"));
        }
        Ok(Self { by, part, of })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn partition(text: &str) -> Partition {
        text.parse().unwrap()
    }

    #[test]
    fn every_unit_is_in_exactly_one_share() {
        let keys: Vec<_> = (0..200).map(|number| format!("zebra/scripted/tta={number}s")).collect();
        for by in ["slice", "hash"] {
            let shares: Vec<_> = (1..=4).map(|part| partition(&format!("{by}:{part}/4"))).collect();
            for (place, key) in keys.iter().enumerate() {
                let holders = shares.iter().filter(|share| share.holds(place, key)).count();
                assert_eq!(holders, 1, "{by} {key}");
            }
        }
    }

    #[test]
    fn slices_take_turns_and_hashes_are_golden() {
        let taken: Vec<_> = (0..7).filter(|place| partition("slice:2/3").holds(*place, "")).collect();
        assert_eq!(taken, [1, 4]);
        // Another share for a key would be run twice or never by machines with different versions.
        assert_eq!(hash("zebra/scripted/tta=6s"), GOLDEN);
    }

    const GOLDEN: u64 = 17_044_003_264_083_291_523;

    #[test]
    fn what_is_no_partition_is_refused() {
        for (text, said) in [
            ("1/4", "write it like"),
            ("count:1/4", "write it like"),
            ("hash:x/4", "write it like"),
            ("hash:0/4", "count from 1"),
            ("slice:5/4", "no share 5 of 4"),
        ] {
            assert!(text.parse::<Partition>().unwrap_err().contains(said), "{text}");
        }
    }
}
