// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/panel.h"

namespace plumbline {

// One function per panel, each in a file of its own. docs/panels.md shows them.

std::unique_ptr<Panel> MakeImagePanel();
std::unique_ptr<Panel> MakeEdgesPanel();
std::unique_ptr<Panel> MakeDepthPanel();
std::unique_ptr<Panel> MakeMasksPanel();
std::unique_ptr<Panel> MakeParticlesPanel();
std::unique_ptr<Panel> MakeScenePanel();
std::unique_ptr<Panel> MakeObjectsPanel();
std::unique_ptr<Panel> MakeDetailsPanel();
std::unique_ptr<Panel> MakeFlowPanel();
std::unique_ptr<Panel> MakeWhyPanel();
std::unique_ptr<Panel> MakeParticleTablePanel();
std::unique_ptr<Panel> MakePosteriorPanel();
std::unique_ptr<Panel> MakeRelationsPanel();
std::unique_ptr<Panel> MakeTimingsPanel();
std::unique_ptr<Panel> MakeTimelinePanel();
std::unique_ptr<Panel> MakeWhatIfPanel();
/// The image of the other run, beside that of the first.
std::unique_ptr<Panel> MakeOtherImagePanel();

}  // namespace plumbline
