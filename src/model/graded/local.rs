//! Second derivatives of density and fall at one point, by the fields there.
//!
//! The density depends on the fields through the fundamental forms, so its Hessian is theirs (`density`) between the derivatives of the forms, and what the
//! forms themselves are curved; c, c_σ and c_σσ follow from `c² = 1 − x² − y²`, so their curvature is products of their own tangents.

use super::Setup;
use super::density::{E, E2, F, F2, Forms, G2, Site};
use super::force::{Force, slopes};
use crate::numerics::lanes::Vector;

/// Fields by their place in tangents and second derivatives: those that a ring's directions move in their own way …
pub(super) const X: usize = 0;
pub(super) const Y: usize = 1;
pub(super) const X2: usize = 2;
pub(super) const Y2: usize = 3;
pub(super) const C: usize = 4;
pub(super) const CS: usize = 5;
pub(super) const CSS: usize = 6;
pub(super) const OWN: usize = 7;
/// … 1 + ψ_σ and −Rψ_ℓ, and the two that come from all rings.
pub(super) const T: usize = 7;
pub(super) const A: usize = 8;
pub(super) const P: usize = 9;
pub(super) const R: usize = 10;
pub(super) const ALL: usize = 11;

/// Second derivatives of density and fall by the fields, into `w`; symmetric, only `[i][j]` with i ≤ j is filled.
#[inline(always)]
pub(super) fn local<V: Vector>(w: &mut [[V; ALL]; ALL], s: &Site<V>, force: &Force, cloth: V, setup: &Setup) {
    for row in w.iter_mut() {
        for entry in row.iter_mut() {
            *entry = V::zero();
        }
    }
    let forms = Forms::of(s);
    let slopes = slopes(&forms, cloth, setup);
    let mut bent = [[V::zero(); 5]; 5];
    if setup.rigidity != 0.0 {
        bent = forms.bending_curvatures(cloth * setup.rigidity);
    }
    if setup.shear != 0.0 {
        let [ee, ef, ff] = forms.shear_curvatures(cloth * setup.shear);
        bent[E][E] = bent[E][E] + ee;
        (bent[E][F], bent[F][E]) = (bent[E][F] + ef, bent[F][E] + ef);
        bent[F][F] = bent[F][F] + ff;
    }
    let [n0, n1, n2] = forms.normal;
    let (ring, over) = (s.ring, s.ring * s.inverse);
    let dot = s.x.mul_add(s.x2, s.y * s.y2);
    // Fields that enter one form only: their derivative of it.
    let single = [
        (X2, G2, (over * s.x).neg_mul_add(s.x, n0)),
        (Y2, G2, (over * s.x).neg_mul_add(s.y, n1)),
        (CS, F2, -n2),
        (T, E2, -(n0 * ring)),
        (A, F2, n0),
        (R, E2, n2),
    ];
    // Fields that enter several: derivatives of the forms.
    let zero = V::zero();
    let bent_x = s.p.mul_sub(s.y2, over * s.x.mul_add(s.x2, dot));
    let bent_y = -(s.p.mul_add(s.x2, over * s.x * s.y2));
    let bent_c = (over * s.x * s.inverse).mul_sub(dot, s.x2 * ring);
    let bent_p = s.x.mul_sub(s.y2, s.y * s.x2);
    let several = [
        (X, [zero, zero, -(s.r * ring), s.growth.mul_add(s.p, s.cs * ring), bent_x]),
        (Y, [zero, ring, s.t * ring * s.p, -(s.a * s.p), bent_y]),
        (C, [zero, -s.p, s.t * ring * ring, -(s.a * ring), bent_c]),
        (P, [s.p * 2.0, -s.c, s.t * ring * s.y, s.growth.mul_sub(s.x, s.a * s.y), bent_p]),
    ];
    for (i, (field, own)) in several.iter().enumerate() {
        let mut by = [zero; 5];
        for to in 0..5 {
            by[to] = own[F] * bent[to][F];
            for from in [E2, F2, G2] {
                by[to] = own[from].mul_add(bent[to][from], by[to]);
            }
            if *field == P {
                by[to] = own[E].mul_add(bent[to][E], by[to]);
            }
        }
        for (other, theirs) in &several[i..] {
            let mut sum = theirs[F] * by[F];
            for form in [E2, F2, G2] {
                sum = theirs[form].mul_add(by[form], sum);
            }
            if *other == P {
                sum = theirs[E].mul_add(by[E], sum);
            }
            add(w, *field, *other, sum);
        }
        for (other, form, theirs) in &single {
            add(w, *field, *other, *theirs * by[*form]);
        }
    }
    for (i, (field, form, own)) in single.iter().enumerate() {
        for (other, to, theirs) in &single[i..] {
            add(w, *field, *other, *own * *theirs * bent[*form][*to]);
        }
    }
    // Curvature of the forms themselves.
    let [e, f, e2, f2, g2] = [slopes[E], slopes[F], slopes[E2], slopes[F2], slopes[G2]];
    let (along, lever) = (over * g2, over * s.inverse * g2);
    add(w, P, P, e * 2.0);
    add(w, C, P, -f);
    add(w, C, T, ring * ring * e2);
    add(w, T, P, ring * s.y * e2);
    add(w, Y, T, ring * s.p * e2);
    add(w, Y, P, (s.t * ring).mul_sub(e2, s.a.mul_add(f2, s.x2 * g2)));
    add(w, X, R, -(ring * e2));
    add(w, C, A, -(ring * f2));
    add(w, A, P, -(s.y * f2));
    add(w, Y, A, -(s.p * f2));
    add(w, X, P, s.growth.mul_add(f2, s.y2 * g2));
    add(w, X, CS, ring * f2);
    add(w, X2, C, (lever * s.x).mul_sub(s.x, ring * g2));
    add(w, X2, P, -(s.y * g2));
    add(w, Y, X2, -(s.p * g2));
    add(w, Y2, P, s.x * g2);
    add(w, X, Y2, s.p.mul_sub(g2, along * s.y));
    add(w, X, X, along * s.x2 * -2.0);
    add(w, X, Y, -(along * s.y2));
    add(w, X, X2, along * s.x * -2.0);
    add(w, Y, Y2, -(along * s.x));
    add(w, X, C, lever * s.x.mul_add(s.x2, dot));
    add(w, Y, C, lever * s.x * s.y2);
    add(w, Y2, C, lever * s.x * s.y);
    add(w, C, C, lever * s.inverse * s.x * dot * -2.0);
    // And of the fall.
    let [itself, first, second] = [V::of(&force.fall[0]), V::of(&force.fall[1]), V::of(&force.fall[2])];
    for field in [X, Y, C] {
        add(w, field, field, -itself);
    }
    add(w, C, CS, -first);
    add(w, C, CSS, -second);
    add(w, CS, CS, second * -2.0);
    add(w, X, A, -first);
    add(w, A, A, second * -2.0);
    add(w, X, T, second * s.growth);
    add(w, Y, T, -(second * s.a));
    add(w, Y, A, -(second * s.t));
    add(w, T, A, -(second * s.y));
}

#[inline(always)]
fn add<V: Vector>(w: &mut [[V; ALL]; ALL], i: usize, j: usize, more: V) {
    let (i, j) = if i < j { (i, j) } else { (j, i) };
    w[i][j] = w[i][j] + more;
}

#[inline(always)]
pub(super) fn at<V: Vector>(w: &[[V; ALL]; ALL], i: usize, j: usize) -> V {
    if i < j { w[i][j] } else { w[j][i] }
}
