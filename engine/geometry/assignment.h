// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace plumbline {

/// One-to-one assignment of rows to columns: as many pairs as the finite entries of `cost` allow,
/// and among those the smallest sum. Entries must be >= 0; infinity forbids a pair. Entry i of the
/// result is the column of row i. The Hungarian method with potentials, O(n^3); H. W. Kuhn, 1955,
/// in the form of J. Edmonds and R. Karp, 1972.
std::vector<std::optional<int>> AssignOneToOne(const Eigen::MatrixXd& cost);

}  // namespace plumbline
