// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/assignment.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace plumbline {
namespace {

/// Columns of all rows for finite costs and no more rows than columns: rows enter one by one, each
/// along the shortest augmenting path in reduced costs.
std::vector<int> AssignRows(const Eigen::MatrixXd& cost) {
  const int rows = static_cast<int>(cost.rows()), n = static_cast<int>(cost.cols());
  const double infinity = std::numeric_limits<double>::infinity();
  std::vector<double> row_potential(rows, 0.0), column_potential(n + 1, 0.0);
  std::vector<int> row_of_column(n + 1, -1);  // column n is the root of the paths
  for (int row = 0; row < rows; ++row) {
    std::vector<double> shortest(n + 1, infinity);
    std::vector<int> previous(n + 1, n);
    std::vector<bool> reached(n + 1, false);
    int column = n;
    row_of_column[n] = row;
    while (row_of_column[column] >= 0) {
      reached[column] = true;
      const int from = row_of_column[column];
      int next = -1;
      for (int c = 0; c < n; ++c) {
        if (reached[c]) continue;
        const double reduced = cost(from, c) - row_potential[from] - column_potential[c];
        if (reduced < shortest[c]) {
          shortest[c] = reduced;
          previous[c] = column;
        }
        if (next < 0 || shortest[c] < shortest[next]) next = c;
      }
      const double step = shortest[next];
      for (int c = 0; c <= n; ++c) {
        if (reached[c]) {
          row_potential[row_of_column[c]] += step;
          column_potential[c] -= step;
        } else {
          shortest[c] -= step;
        }
      }
      column = next;
    }
    for (; column != n; column = previous[column])
      row_of_column[column] = row_of_column[previous[column]];
  }
  std::vector<int> column_of_row(rows);
  for (int c = 0; c < n; ++c) {
    if (row_of_column[c] >= 0) column_of_row[row_of_column[c]] = c;
  }
  return column_of_row;
}

}  // namespace

std::vector<std::optional<int>> AssignOneToOne(const Eigen::MatrixXd& cost) {
  const int rows = static_cast<int>(cost.rows());
  const int columns = static_cast<int>(cost.cols());
  double finite_sum = 0;
  for (int i = 0; i < cost.size(); ++i) {
    if (std::isfinite(cost.data()[i])) finite_sum += cost.data()[i];
  }
  // One forbidden pair costs more than all allowed ones together: the number of pairs comes first.
  Eigen::MatrixXd filled =
      Eigen::MatrixXd::Constant(rows, std::max(rows, columns), 2 * finite_sum + 1);
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      if (std::isfinite(cost(i, j))) filled(i, j) = cost(i, j);
    }
  }
  const std::vector<int> assigned = AssignRows(filled);
  std::vector<std::optional<int>> result(rows);
  for (int i = 0; i < rows; ++i) {
    if (assigned[i] < columns && std::isfinite(cost(i, assigned[i]))) result[i] = assigned[i];
  }
  return result;
}

}  // namespace plumbline
