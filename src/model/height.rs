//! Functions of height: how the fold coefficients of the graded shell vary from waist to hem.

/// Functions of height in which the coefficients a_k(u) are expanded: `a_k = s(u) Σ_j α_kj T_j(2s − 1)`, s(0) = 0, s(1) = 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HeightBasis {
    /// s = u. Converges slowly: below the waist inextensible rings make a_k grow like √u.
    Polynomial,
    /// `s ∝ √(u + width) − √width`: the root away from the waist, regular through a layer of this width (a fraction of the slant).
    Layer { width: f64 },
}

impl HeightBasis {
    /// u(s) with its first and second derivative.
    pub(super) fn height(&self, s: f64) -> (f64, f64, f64) {
        match *self {
            HeightBasis::Polynomial => (s, 1.0, 0.0),
            HeightBasis::Layer { width } => {
                let root = width.sqrt();
                let span = (1.0 + width).sqrt() - root;
                let t = span * s;
                (t * (t + 2.0 * root), 2.0 * span * (t + root), 2.0 * span * span)
            }
        }
    }

    /// s T_j(2s − 1) for j < count: value and two derivatives by ℓ = uL, at s.
    pub(super) fn functions(&self, s: f64, count: usize, slant: f64) -> Vec<[f64; 3]> {
        let (_, u1, u2) = self.height(s);
        let x = 2.0 * s - 1.0;
        // Chebyshev recurrence with derivatives by x.
        let mut table = vec![[1.0, 0.0, 0.0], [x, 1.0, 0.0]];
        for j in 2..count {
            let (a, b) = (table[j - 1], table[j - 2]);
            table.push([2.0 * x * a[0] - b[0], 2.0 * a[0] + 2.0 * x * a[1] - b[1], 4.0 * a[1] + 2.0 * x * a[2] - b[2]]);
        }
        let convert = |[t, t1, t2]: [f64; 3]| {
            let (by_s, by_ss) = (t + 2.0 * s * t1, 4.0 * t1 + 4.0 * s * t2);
            let (first, second) = (by_s / u1, (by_ss - by_s * u2 / u1) / (u1 * u1));
            [s * t, first / slant, second / (slant * slant)]
        };
        table.into_iter().take(count).map(convert).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_by_slant_distance_agree_with_central_differences() {
        let slant = 0.53;
        for basis in [HeightBasis::Polynomial, HeightBasis::Layer { width: 0.03 }] {
            for s in [0.05, 0.3, 0.77, 1.0] {
                let h = 1e-5;
                let at = |s: f64| (basis.height(s).0 * slant, basis.functions(s, 5, slant));
                let ((below, a), (_, exact), (above, b)) = (at(s - h), at(s), at(s + h));
                for j in 0..5 {
                    for d in 0..2 {
                        let numeric = (b[j][d] - a[j][d]) / (above - below);
                        // Truncation h²f‴/6 relative to scales of f‴ that grow towards the waist; rounding eps·f/h.
                        assert!(
                            (numeric - exact[j][d + 1]).abs() < 1e-5 * (1.0 + exact[j][d + 1].abs()),
                            "{basis:?} {s} {j} {d}: {numeric}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn height_runs_from_waist_to_hem_and_its_functions_start_at_zero() {
        for basis in [HeightBasis::Polynomial, HeightBasis::Layer { width: 1e-4 }, HeightBasis::Layer { width: 1.0 }] {
            assert!(basis.height(0.0).0.abs() < 1e-15 && (basis.height(1.0).0 - 1.0).abs() < 1e-14);
            assert!(basis.functions(0.0, 6, 1.0).iter().all(|f| f[0] == 0.0));
            // At the hem s = 1 and every T_j is 1.
            assert!(basis.functions(1.0, 6, 1.0).iter().all(|f| (f[0] - 1.0).abs() < 1e-14));
        }
    }
}
