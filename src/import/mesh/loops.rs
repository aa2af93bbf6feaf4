//! Loops: pieces of line that share ends, put together into closed loops and open chains, with small gaps bridged.

use std::collections::HashMap;

/// Chains shorter than this share of the longest are specks at the rim of a hole: they are not used to bridge a gap.
const SPECK: f64 = 0.01;
/// At most so many open chains are put together: a surface with more holes than this at one height is a heap of pieces.
const MOST_CHAINS: usize = 32;

/// Where many sheets meet in a seam, so many of them are looked at for the one that goes straight on.
const SEAM: usize = 16;

/// A way through nodes; a closed one does not repeat its first node.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chain {
    pub nodes: Vec<u32>,
    pub closed: bool,
    /// Length of the gaps that were bridged to close it.
    pub bridged: f64,
}

/// Follows segments (pairs of nodes) from end to end. Where more than two meet, it goes on with the one that turns least.
pub(super) fn follow(segments: &[[u32; 2]], turn: impl Fn(u32, u32, u32) -> f64) -> Vec<Chain> {
    // Looked up, never iterated over: the segments that meet at each node, first ones last.
    let mut meeting: HashMap<u32, Vec<u32>> = HashMap::new();
    for (at, segment) in segments.iter().enumerate().rev() {
        segment.iter().for_each(|&node| meeting.entry(node).or_default().push(at as u32));
    }
    let simple: HashMap<u32, bool> = meeting.iter().map(|(&node, there)| (node, there.len() == 2)).collect();
    let mut used = vec![false; segments.len()];
    let mut chains = Vec::new();
    // Loose ends first, so that an open chain is found whole.
    let loose = |at: &usize| segments[*at].iter().any(|node| !simple[node]);
    let starts: Vec<usize> = (0..segments.len()).filter(loose).chain((0..segments.len()).filter(|at| !loose(at))).collect();
    for start in starts {
        if used[start] {
            continue;
        }
        used[start] = true;
        let [a, b] = segments[start];
        let mut nodes = if !simple[&a] || simple[&b] { vec![a, b] } else { vec![b, a] };
        loop {
            let (before, here) = (nodes[nodes.len() - 2], nodes[nodes.len() - 1]);
            let there = meeting.get_mut(&here).map_or(&[][..], |there| {
                while there.last().is_some_and(|&last| used[last as usize]) {
                    there.pop();
                }
                &there[there.len().saturating_sub(SEAM)..]
            });
            let onward = there.iter().rev().filter(|&&s| !used[s as usize]).map(|&s| {
                let [from, to] = segments[s as usize];
                (s, if from == here { to } else { from })
            });
            let onward: Vec<(u32, u32)> = onward.collect();
            let next = match onward[..] {
                [] => None,
                [only] => Some(only),
                _ => onward.iter().copied().min_by(|x, y| turn(before, here, x.1).total_cmp(&turn(before, here, y.1))),
            };
            let Some((segment, to)) = next else { break };
            used[segment as usize] = true;
            nodes.push(to);
            if to == nodes[0] {
                break;
            }
        }
        let closed = 3 < nodes.len() && nodes.first() == nodes.last();
        if closed {
            nodes.pop();
        }
        chains.push(Chain { nodes, closed, bridged: 0.0 });
    }
    chains
}

/// Closes open chains over gaps, the smallest gaps first, as long as a loop's gaps stay within `most` of its length.
pub(super) fn bridge(chains: Vec<Chain>, most: f64, distance: impl Fn(u32, u32) -> f64) -> Vec<Chain> {
    let (mut done, open): (Vec<Chain>, Vec<Chain>) = chains.into_iter().partition(|chain| chain.closed);
    let along = |chain: &Chain| chain.nodes.windows(2).map(|pair| distance(pair[0], pair[1])).sum::<f64>();
    let mut measured: Vec<(f64, Chain)> = open.into_iter().map(|chain| (along(&chain), chain)).collect();
    measured.sort_by(|a, b| b.0.total_cmp(&a.0));
    let longest = measured.first().map_or(0.0, |(length, _)| *length);
    let rest = measured.split_off(measured.len().min(MOST_CHAINS));
    let (mut open, specks): (Vec<_>, Vec<_>) = measured.into_iter().partition(|(length, _)| SPECK * longest < *length);
    done.extend(rest.into_iter().chain(specks).map(|(_, chain)| chain));
    while !open.is_empty() {
        // The two nearest loose ends of all; (i, i) closes chain i.
        let end = |i: usize, last: bool| if last { open[i].1.nodes[open[i].1.nodes.len() - 1] } else { open[i].1.nodes[0] };
        let mut nearest = (f64::INFINITY, 0, true, 0, false);
        for i in 0..open.len() {
            for j in i..open.len() {
                for (last_i, last_j) in [(true, false), (true, true), (false, false), (false, true)] {
                    if i == j && (last_i, last_j) != (true, false) {
                        continue;
                    }
                    let gap = distance(end(i, last_i), end(j, last_j));
                    // A gap as long as what it would close is none.
                    let reach = if i == j { open[i].0 } else { open[i].0 + open[j].0 };
                    if gap < nearest.0 && gap <= most * (reach + gap).max(longest) {
                        nearest = (gap, i, last_i, j, last_j);
                    }
                }
            }
        }
        let (gap, i, last_i, j, last_j) = nearest;
        if gap.is_infinite() {
            break;
        }
        if i == j {
            let (length, mut chain) = open.remove(i);
            chain.bridged += gap;
            // Kept open and said so where the gaps add up to more than is allowed.
            chain.closed = chain.bridged <= most * (length + gap) && 3 <= chain.nodes.len();
            done.push(chain);
        } else {
            let (length_j, mut second) = open.remove(j);
            let (length_i, mut first) = open.remove(i);
            if !last_i {
                first.nodes.reverse();
            }
            if last_j {
                second.nodes.reverse();
            }
            first.nodes.extend(second.nodes);
            first.bridged += second.bridged + gap;
            open.push((length_i + length_j + gap, first));
        }
    }
    done.extend(open.into_iter().map(|(_, chain)| chain));
    done
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(n: u32, without: &[u32]) -> Vec<[u32; 2]> {
        (0..n).filter(|i| !without.contains(i)).map(|i| [(i + 1) % n, i]).collect()
    }

    fn on_circle(n: u32) -> impl Fn(u32, u32) -> f64 {
        move |a, b| 2.0 * (std::f64::consts::PI * (f64::from(a) - f64::from(b)) / f64::from(n)).sin().abs()
    }

    #[test]
    fn segments_in_any_order_and_direction_make_one_loop() {
        let mut segments = ring(30, &[]);
        for k in 0..10 {
            segments.swap(k, (7 * k + 3) % 30);
            segments[(3 * k) % 30].reverse();
        }
        let chains = follow(&segments, |_, _, _| 0.0);
        assert_eq!((chains.len(), chains[0].closed, chains[0].nodes.len()), (1, true, 30));
    }

    #[test]
    fn gaps_are_bridged_up_to_the_stated_share_and_no_further() {
        let chains = follow(&ring(100, &[10, 50, 51]), |_, _, _| 0.0);
        assert_eq!(chains.len(), 2);
        // Three of a hundred steps are missing, and with two of them the node between.
        let whole = bridge(chains.clone(), 0.035, on_circle(100));
        assert_eq!((whole.len(), whole[0].closed, whole[0].nodes.len()), (1, true, 99));
        let parted = bridge(chains, 0.015, on_circle(100));
        assert!(parted.iter().all(|chain| !chain.closed));
    }
}
