// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/base/ids.h"

namespace plumbline {

enum class RelationKind {
  kNear,      ///< `b` is the nearest neighbour of `a`; value: gap between them [m].
  kStandsOn,  ///< `a` stands on `b`; value: gap between them [m].
  kHides      ///< `a` hides a share `value` of `b` from the camera of this frame.
};

/// How two confirmed objects of a frame stand to one another.
struct ObjectRelation {
  RelationKind kind = RelationKind::kNear;
  ObjectId a, b;
  double value = 0;
};

/// "hides", "stands on", "is nearest to": between the names of two objects.
constexpr const char* RelationName(RelationKind kind) {
  switch (kind) {
    case RelationKind::kNear:
      return "is nearest to";
    case RelationKind::kStandsOn:
      return "stands on";
    case RelationKind::kHides:
      return "hides";
  }
  return "";
}

}  // namespace plumbline
