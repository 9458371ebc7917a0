// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace plumbline {

/// In which 95 of 100 runs lie whose beliefs are honest.
struct NeesInterval {
  double low = 0, high = 0;
};

/// Of the mean of the normalised estimation errors squared of so many independent objects, whose
/// place and azimuth are each told as Student's t with its covariance. By 2000 fixed draws, to
/// some per cent.
/// @param degrees_of_freedom  Of Student's t; even, more than 2.
NeesInterval HonestMeanNees(int objects, int degrees_of_freedom);

}  // namespace plumbline
