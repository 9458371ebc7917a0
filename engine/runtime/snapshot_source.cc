// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/snapshot_source.h"

#include "engine/snapshot/map_snapshot.h"

namespace plumbline {

ProbeView SnapshotSource::Probe(const MapSnapshot& snapshot, const ProbeCommand& request) {
  ProbeView nothing;
  nothing.frame = snapshot.report.frame;
  nothing.object = request.object;
  nothing.message = "This source cannot score hypotheses again.";
  return nothing;
}

}  // namespace plumbline
