// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "engine/base/result.h"
#include "engine/geometry/mesh.h"
#include "engine/models/file_frame.h"
#include "engine/models/thing_table.h"

namespace plumbline {

/// A guess with the reason in words and how sure it is: 1 certain, 0.5 a coin.
template <typename T>
struct Guess {
  T value{};
  double confidence = 0;
  std::string reason;
  std::vector<std::pair<T, double>> shares;  ///< Of all that were weighed, the likeliest first.
};

/// What is known about a mesh besides its shape.
struct KnownOfMesh {
  std::string extension;         ///< ".stl", lower case: formats have habits.
  const Thing* thing = nullptr;  ///< nullptr: unknown.
  double metres = 1;             ///< One unit of the file.
};

/// Whether a mesh of this size [m] may be such a thing, whichever way it stands or lies: no side is
/// further from the usual than three and a half deviations.
bool FitsThing(const Eigen::Vector3d& size_m, const Thing& thing);

/// The unit in which `size` (of the bounding box) fits the thing best, else things in a room.
Guess<LengthUnit> GuessUnit(const Eigen::Vector3d& size, const KnownOfMesh& known);

/// The axis that points up: on its supporting plane the object stands stably, well balanced and
/// perhaps on feet, the plane goes through the file's origin, what is above differs from what is
/// below while left and right are alike, seats and tops are level, and it is as high, wide and deep
/// as usual; positive axes and those usual for the format come first. With `only_axis` just its
/// sign is in question. Errors: kDegenerate for a mesh without area.
Result<Guess<SignedAxis>> GuessUp(const TriangleMesh& mesh, const KnownOfMesh& known,
                                  std::optional<int> only_axis = std::nullopt);

/// The horizontal axis that the object faces, given the one that points up: left and right are
/// alike; a seat's back rest is at the back; a cabinet's front is a wide side and has the doors; a
/// screen is flat and held from behind. Errors: kDegenerate.
Result<Guess<SignedAxis>> GuessFront(const TriangleMesh& mesh, const SignedAxis& up,
                                     const KnownOfMesh& known);

}  // namespace plumbline
