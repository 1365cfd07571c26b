//! Which functions can be reached from a function of a Thumb-2 image, by its branches, and how much stack that takes, by what
//! each function subtracts from the stack pointer.
//!
//! # Limitations
//! A call through a register cannot be followed; it is reported, so that a proof can demand that there is none.

use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// The code of an image.
pub struct CallGraph {
    begin: u32,
    code: Vec<u8>,
    /// First address of a function to its end and name.
    functions: BTreeMap<u32, (u32, String)>,
    /// First address of a stretch to whether it is code; tables and constants lie between the instructions.
    stretches: BTreeMap<u32, bool>,
}

/// What a function can reach.
#[derive(Debug, Default)]
pub struct Reach {
    /// Names of the functions.
    pub functions: BTreeSet<String>,
    /// Addresses of calls and jumps through registers.
    pub unknown: Vec<u32>,
}

/// The effect of an instruction on the control flow.
enum Flow {
    To(u32),
    Register,
    On,
}

impl CallGraph {
    /// The call graph of an ELF image.
    ///
    /// # Errors
    /// It is not an ELF image, or has no code.
    pub fn new(image: &[u8]) -> Result<Self, String> {
        let file = object::File::parse(image).map_err(|e| e.to_string())?;
        let text = file.section_by_name(".text").ok_or("there is no .text")?;
        let code = text.data().map_err(|e| e.to_string())?.to_vec();
        let begin = text.address() as u32;
        let inside = begin..begin + code.len() as u32;
        let (mut functions, mut stretches) = (BTreeMap::new(), BTreeMap::new());
        for symbol in file.symbols() {
            let name = symbol.name().unwrap_or_default();
            // Bit 0 of a function's address says that it is Thumb code.
            let at = symbol.address() as u32 & !1;
            if !inside.contains(&at) {
                continue;
            }
            if name.starts_with("$t") || name.starts_with("$d") {
                stretches.insert(at, name.starts_with("$t"));
            } else if symbol.kind() == SymbolKind::Text && symbol.size() > 0 {
                functions.insert(at, (at + symbol.size() as u32, name.to_owned()));
            }
        }
        Ok(Self {
            begin,
            code,
            functions,
            stretches,
        })
    }

    /// Everything that `name` can reach, including itself, but not through functions with `stop` in their names.
    ///
    /// # Errors
    /// There is no such function, or a branch leads to no function.
    pub fn reach(&self, name: &str, stop: &str) -> Result<Reach, String> {
        let first = self.functions.iter().find(|(_, (_, n))| n == name);
        let mut open = vec![*first.ok_or(format!("there is no {name}"))?.0];
        let (mut seen, mut reach) = (BTreeSet::new(), Reach::default());
        while let Some(at) = open.pop() {
            let (&begin, (end, name)) = self
                .functions
                .range(..=at)
                .next_back()
                .filter(|(_, (end, _))| at < *end)
                .ok_or(format!("{at:#010x} is in no function"))?;
            if seen.insert(begin) {
                reach.functions.insert(name.clone());
                if name.contains(stop) {
                    continue;
                }
                self.branches(begin..*end, |from, flow| match flow {
                    Flow::To(to) if (begin..*end).contains(&to) => {}
                    Flow::To(to) => open.push(to),
                    Flow::Register => reach.unknown.push(from),
                    Flow::On => {}
                });
            }
        }
        Ok(reach)
    }

    /// Address ranges of the functions with these names.
    pub fn ranges(&self, names: &BTreeSet<String>) -> Vec<Range<u32>> {
        let all = self.functions.iter();
        all.filter(|(_, (_, name))| names.contains(name))
            .map(|(&begin, &(end, _))| begin..end)
            .collect()
    }

    /// First address and bytes of the code.
    pub fn code(&self) -> (u32, &[u8]) {
        (self.begin, &self.code)
    }

    /// The bytes of the function with `part` in its name, up to its first call or jump elsewhere.
    ///
    /// # Errors
    /// There is no such function, or more than one.
    pub fn before_first_call(&self, part: &str) -> Result<&[u8], String> {
        let mut all = self
            .functions
            .iter()
            .filter(|(_, (_, name))| name.contains(part));
        let (Some((&begin, (end, _))), None) = (all.next(), all.next()) else {
            return Err(format!("there is not one {part}"));
        };
        let mut until = *end;
        self.branches(begin..*end, |at, flow| match flow {
            Flow::To(to) if (begin..*end).contains(&to) => {}
            Flow::On => {}
            Flow::To(_) | Flow::Register => until = until.min(at),
        });
        let range = (begin - self.begin) as usize..(until - self.begin) as usize;
        self.code
            .get(range)
            .ok_or(format!("{part} lies outside the code"))
    }

    /// Names of all functions with `part` in them.
    pub fn names<'a>(&'a self, part: &'a str) -> impl Iterator<Item = &'a str> {
        let names = self.functions.values().map(|(_, name)| name.as_str());
        names.filter(move |name| name.contains(part))
    }

    /// Bytes of stack on the deepest call path from `name`, without calls to functions with one of `stop` in their names, and
    /// the functions on that path with what each takes.
    ///
    /// # Errors
    /// There is no such function, a branch leads to no function, or functions call each other recursively.
    pub fn stack(&self, name: &str, stop: &[&str]) -> Result<(u32, Vec<(String, u32)>), String> {
        let first = self.functions.iter().find(|(_, (_, n))| n == name);
        let first = *first.ok_or(format!("there is no {name}"))?.0;
        let mut known = BTreeMap::new();
        self.deepest(first, stop, &mut known, &mut Vec::new())?;
        let (mut way, mut at) = (Vec::new(), Some(first));
        while let Some(begin) = at {
            let (_, next) = known[&begin];
            way.push((self.functions[&begin].1.clone(), self.frame(begin)));
            at = next;
        }
        Ok((known[&first].0, way))
    }

    /// Depth from `begin`; `known` keeps it with the callee on the deepest path.
    fn deepest(
        &self,
        begin: u32,
        stop: &[&str],
        known: &mut BTreeMap<u32, (u32, Option<u32>)>,
        above: &mut Vec<u32>,
    ) -> Result<u32, String> {
        if let Some((depth, _)) = known.get(&begin) {
            return Ok(*depth);
        }
        let (end, name) = &self.functions[&begin];
        if above.contains(&begin) {
            return Err(format!("{name} can come to itself"));
        }
        above.push(begin);
        let mut callees = BTreeSet::new();
        self.branches(begin..*end, |_, flow| match flow {
            Flow::To(to) if !(begin..*end).contains(&to) => {
                callees.insert(to);
            }
            _ => {}
        });
        let (mut below, mut next) = (0, None);
        for to in callees {
            let (&callee, (end, name)) = self
                .functions
                .range(..=to)
                .next_back()
                .ok_or(format!("{to:#010x} is in no function"))?;
            if to >= *end {
                return Err(format!("{to:#010x} is in no function"));
            }
            if callee == begin || stop.iter().any(|s| name.contains(s)) {
                continue;
            }
            let depth = self.deepest(callee, stop, known, above)?;
            if depth > below {
                (below, next) = (depth, Some(callee));
            }
        }
        above.pop();
        let depth = self.frame(begin) + below;
        known.insert(begin, (depth, next));
        Ok(depth)
    }

    /// Total bytes that the functions with `part` in their names subtract from the stack pointer themselves.
    pub fn frames(&self, part: &str) -> u32 {
        let all = self.functions.iter();
        all.filter(|(_, (_, name))| name.contains(part))
            .map(|(begin, _)| self.frame(*begin))
            .sum()
    }

    /// The most that one function subtracts from the stack pointer, bytes, and its name.
    pub fn largest_frame(&self) -> (u32, &str) {
        let all = self.functions.iter();
        all.map(|(begin, (_, name))| (self.frame(*begin), name.as_str()))
            .max()
            .unwrap_or_default()
    }

    fn frame(&self, begin: u32) -> u32 {
        let end = self.functions[&begin].0;
        let (mut at, mut bytes) = (begin, 0);
        while at < end {
            let is_code = self.stretches.range(..=at).next_back();
            let (first, second) = (self.half(at), self.half(at + 2));
            if is_code.is_some_and(|(_, &code)| code) {
                bytes += taken(first, second);
                at += if first >> 11 < 0b11101 { 2 } else { 4 };
            } else {
                at += 2;
            }
        }
        bytes
    }

    fn branches(&self, function: Range<u32>, mut each: impl FnMut(u32, Flow)) {
        let mut at = function.start;
        while at < function.end {
            let is_code = self.stretches.range(..=at).next_back();
            if !is_code.is_some_and(|(_, &code)| code) {
                at += 2;
                continue;
            }
            let (length, flow) = decode(at, self.half(at), self.half(at + 2));
            each(at, flow);
            at += length;
        }
    }

    fn half(&self, at: u32) -> u16 {
        let i = (at - self.begin) as usize;
        self.code
            .get(i..i + 2)
            .map_or(0, |b| u16::from_le_bytes([b[0], b[1]]))
    }
}

/// The instruction at `at`: its length, and where it may branch. Encodings by the ARMv7-M manual, A7.7.
fn decode(at: u32, first: u16, second: u16) -> (u32, Flow) {
    let to = |offset: i32| Flow::To(at.wrapping_add(4).wrapping_add_signed(offset));
    // The low `bits` of `value`, with its sign.
    let signed = |value: u32, bits: u32| ((value << (32 - bits)) as i32) >> (32 - bits);
    if first >> 11 < 0b11101 {
        let flow = match first {
            // B<c>, except the undefined one and the supervisor call.
            0xd000..=0xddff => to(signed(u32::from(first & 0xff) << 1, 9)),
            0xe000..=0xe7ff => to(signed(u32::from(first & 0x7ff) << 1, 12)),
            // CBZ and CBNZ go forward only.
            _ if first & 0xf500 == 0xb100 => {
                let i = u32::from(first);
                to(((i >> 3 & 0x1f) << 1 | (i >> 9 & 1) << 6) as i32)
            }
            // BX and BLX, except the return by LR.
            _ if first & 0xff00 == 0x4700 && first & 0x78 != 0x70 => Flow::Register,
            _ => Flow::On,
        };
        return (2, flow);
    }
    let (a, b) = (u32::from(first), u32::from(second));
    if first & 0xf800 != 0xf000 || b & 0x8000 == 0 {
        return (4, Flow::On);
    }
    let (sign, j1, j2) = (a >> 10 & 1, b >> 13 & 1, b >> 11 & 1);
    let flow = if b & 0x5000 != 0 && b & 0x5000 != 0x4000 {
        // B.W and BL.
        let (i1, i2) = (1 ^ j1 ^ sign, 1 ^ j2 ^ sign);
        let offset = sign << 24 | i1 << 23 | i2 << 22 | (a & 0x3ff) << 12 | (b & 0x7ff) << 1;
        to(signed(offset, 25))
    } else if b & 0x5000 == 0 && a >> 6 & 0xf < 0xe {
        // B<c>.W.
        let offset = sign << 20 | j2 << 19 | j1 << 18 | (a & 0x3f) << 12 | (b & 0x7ff) << 1;
        to(signed(offset, 21))
    } else {
        // Hints, barriers, special registers.
        Flow::On
    };
    (4, flow)
}

/// Bytes that an instruction subtracts from the stack pointer.
fn taken(first: u16, second: u16) -> u32 {
    let (a, b) = (u32::from(first), u32::from(second));
    let immediate = (a >> 10 & 1) << 11 | (b >> 12 & 7) << 8 | b & 0xff;
    match first {
        // PUSH, SUB SP.
        0xb400..=0xb5ff => (a & 0x1ff).count_ones() * 4,
        0xb080..=0xb0ff => (a & 0x7f) * 4,
        // PUSH.W, PUSH of one register, VPUSH.
        0xe92d => b.count_ones() * 4,
        0xf84d if b & 0xfff == 0xd04 => 4,
        0xed2d | 0xed6d if b & 0xe00 == 0xa00 => (b & 0xff) * 4,
        // SUB.W SP, SP with a modified constant, and SUBW with a plain one.
        0xf1ad | 0xf5ad if b >> 8 & 0x8f == 0x0d => expand(immediate),
        0xf2ad | 0xf6ad if b >> 8 & 0x8f == 0x0d => immediate,
        _ => 0,
    }
}

/// A modified constant of 12 bits, by the manual's `ThumbExpandImm`.
fn expand(immediate: u32) -> u32 {
    let byte = immediate & 0xff;
    match immediate >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte << 24 | byte << 16 | byte << 8 | byte,
        _ => (0x80 | immediate & 0x7f).rotate_right(immediate >> 7),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Instructions as assembled.
    #[test]
    fn what_is_taken_off_the_stack_is_what_an_assembler_says() {
        assert_eq!(taken(0xb5f0, 0), 20, "push {{r4-r7, lr}}");
        assert_eq!(taken(0xe92d, 0x0f00), 16, "push.w {{r8-r11}}");
        assert_eq!(taken(0xb086, 0), 24, "sub sp, #24");
        assert_eq!(taken(0xf84d, 0xbd04), 4, "str r11, [sp, #-4]!");
        assert_eq!(taken(0xed2d, 0x8b10), 64, "vpush {{d8-d15}}");
        assert_eq!(taken(0xf5ad, 0x5d80), 4096, "sub.w sp, sp, #4096");
        assert_eq!(taken(0xf5ad, 0x7d00), 512, "sub.w sp, sp, #512");
        assert_eq!(taken(0xf6ad, 0x0d58), 2136, "subw sp, sp, #2136");
        assert_eq!(taken(0xb006, 0), 0, "add sp, #24");
        assert_eq!(taken(0xf50d, 0x5d80), 0, "add.w sp, sp, #4096");
    }

    /// Instructions as assembled for address 0x1000.
    #[test]
    fn branches_go_where_an_assembler_says() {
        let to = |first, second| match decode(0x1000, first, second) {
            (length, Flow::To(to)) => (length, Some(to)),
            (length, Flow::Register) => (length, Some(0)),
            (length, Flow::On) => (length, None),
        };
        assert_eq!(to(0xe7fe, 0), (2, Some(0x1000)), "b .");
        assert_eq!(to(0xd1fc, 0), (2, Some(0xffc)), "bne");
        assert_eq!(to(0xb108, 0), (2, Some(0x1006)), "cbz r0, .+6");
        assert_eq!(to(0xf000, 0xf87e), (4, Some(0x1100)), "bl .+0x100");
        assert_eq!(to(0xf7ff, 0xfffe), (4, Some(0x1000)), "bl .");
        assert_eq!(to(0xf7ff, 0xbffe), (4, Some(0x1000)), "b.w .");
        assert_eq!(to(0xf43f, 0xaffe), (4, Some(0x1000)), "beq.w .");
        assert_eq!(to(0x4798, 0), (2, Some(0)), "blx r3");
        assert_eq!(to(0x4770, 0), (2, None), "bx lr");
        assert_eq!(to(0xf3bf, 0x8f4f), (4, None), "dsb");
        assert_eq!(to(0xf3ef, 0x8008), (4, None), "mrs r0, msp");
        assert_eq!(to(0xdf00, 0), (2, None), "svc");
    }
}
