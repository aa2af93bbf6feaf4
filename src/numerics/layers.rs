//! Nested functions: local maps between linear ones, with exact gradient and Hessian by many unknowns.
//!
//! A field is a number at every node, with its derivatives by all unknowns. A local map turns fields into fields node by node; its jets have few
//! variables, whatever the number of unknowns. Going back through the maps, each adds what its own curvature contributes to the Hessian:
//! `H = Σ_layers Σ_nodes Tᵀ (λ·∇²F) T`, T the derivatives of its inputs and λ the adjoints of its outputs.

use nalgebra::{DMatrix, DVector};

use super::jet::Jet;

/// A number at every node: its value, and its derivatives (one column for each unknown).
#[derive(Debug, Clone)]
pub struct Field {
    pub value: DVector<f64>,
    pub tangent: DMatrix<f64>,
}

impl Field {
    pub fn zero(nodes: usize, unknowns: usize) -> Self {
        Field { value: DVector::zeros(nodes), tangent: DMatrix::zeros(nodes, unknowns) }
    }

    /// `constant + tangent · x`.
    pub fn linear(constant: f64, tangent: &DMatrix<f64>, x: &DVector<f64>) -> Self {
        Field { value: (tangent * x).add_scalar(constant), tangent: tangent.clone() }
    }
}

/// A local map of M fields to OUT fields, evaluated.
pub struct Layer<const M: usize, const OUT: usize> {
    jets: Vec<[Jet<M>; OUT]>,
    pub outputs: [Field; OUT],
}

/// Maps `inputs` node by node; `None` where the map does not exist at some node.
pub fn map<const M: usize, const OUT: usize>(
    inputs: [&Field; M],
    mut local: impl FnMut(usize, [Jet<M>; M]) -> Option<[Jet<M>; OUT]>,
) -> Option<Layer<M, OUT>> {
    let (nodes, unknowns) = inputs.first().map_or((0, 0), |field| field.tangent.shape());
    let mut jets = Vec::with_capacity(nodes);
    for i in 0..nodes {
        jets.push(local(i, std::array::from_fn(|a| Jet::variable(inputs[a].value[i], a)))?);
    }
    let outputs = std::array::from_fn(|o| {
        let value = DVector::from_iterator(nodes, jets.iter().map(|jet| jet[o].value));
        let mut tangent = DMatrix::zeros(nodes, unknowns);
        for (a, input) in inputs.iter().enumerate() {
            for (mut out, column) in tangent.column_iter_mut().zip(input.tangent.column_iter()) {
                for ((out, jet), d) in out.iter_mut().zip(&jets).zip(column.iter()) {
                    *out += jet[o].gradient[a] * d;
                }
            }
        }
        Field { value, tangent }
    });
    Some(Layer { jets, outputs })
}

impl<const M: usize, const OUT: usize> Layer<M, OUT> {
    /// Adjoints of the inputs from those of the outputs; adds this layer's curvature to the Hessian.
    pub fn back(&self, inputs: [&Field; M], adjoints: [&DVector<f64>; OUT], hessian: &mut DMatrix<f64>) -> [DVector<f64>; M] {
        let nodes = self.jets.len();
        let mut weighted = vec![[[0.0; M]; M]; nodes];
        for ((i, jets), local) in self.jets.iter().enumerate().zip(&mut weighted) {
            for (jet, adjoint) in jets.iter().zip(&adjoints) {
                let lambda = adjoint[i];
                if lambda != 0.0 {
                    for (row, curvature) in local.iter_mut().zip(&jet.hessian) {
                        row.iter_mut().zip(curvature).for_each(|(sum, d)| *sum += lambda * d);
                    }
                }
            }
        }
        for (a, own) in inputs.iter().enumerate() {
            let mut rows = DMatrix::zeros(nodes, hessian.ncols());
            let mut any = false;
            for (b, input) in inputs.iter().enumerate() {
                if weighted.iter().all(|local| local[a][b] == 0.0) {
                    continue;
                }
                any = true;
                for (mut out, column) in rows.column_iter_mut().zip(input.tangent.column_iter()) {
                    for ((out, local), d) in out.iter_mut().zip(&weighted).zip(column.iter()) {
                        *out += local[a][b] * d;
                    }
                }
            }
            if any {
                hessian.gemm_tr(1.0, &own.tangent, &rows, 1.0);
            }
        }
        std::array::from_fn(|a| {
            DVector::from_fn(nodes, |i, _| self.jets[i].iter().zip(&adjoints).map(|(jet, adjoint)| adjoint[i] * jet.gradient[a]).sum())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two layers and a sum: Σ_i sin(p_i q_i) + p_i², p = T x, q = (T x)² + 1.
    fn nested(x: &DVector<f64>) -> (f64, DVector<f64>, DMatrix<f64>) {
        let tangent = DMatrix::from_fn(4, 3, |i, k| ((i + 1) as f64 * 0.3 + k as f64).sin());
        let p = Field::linear(0.2, &tangent, x);
        let first = map([&p], |_, [p]| Some([p.square() + 1.0])).unwrap();
        let q = &first.outputs[0];
        let second = map([&p, q], |_, [p, q]| Some([(p * q).sin_cos().0 + p.square()])).unwrap();
        let ones = DVector::from_element(4, 1.0);
        let mut hessian = DMatrix::zeros(3, 3);
        let [_, back] = second.back([&p, q], [&ones], &mut hessian);
        first.back([&p], [&back], &mut hessian);
        let total = &second.outputs[0];
        (total.value.sum(), total.tangent.tr_mul(&ones), hessian)
    }

    #[test]
    fn gradient_and_hessian_agree_with_central_differences() {
        let x = DVector::from_vec(vec![0.4, -0.3, 0.8]);
        let (_, gradient, hessian) = nested(&x);
        let h = 1e-5;
        for k in 0..3 {
            let step = DVector::from_fn(3, |i, _| if i == k { h } else { 0.0 });
            let (up, down) = (nested(&(&x + &step)), nested(&(&x - &step)));
            // Truncation h²f‴/6 ~ 1e-10 and rounding eps/h ~ 2e-11.
            assert!((gradient[k] - (up.0 - down.0) / (2.0 * h)).abs() < 2e-9);
            assert!((hessian.column(k) - (up.1 - down.1) / (2.0 * h)).amax() < 2e-8);
        }
    }
}
