// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ui/framework/actions.h"

namespace plumbline {

/// Of the 3-D view of whichever workspace shows.
ActionGroup ViewActions();
/// Asks by a list of folders and files for something to open.
void AskWhatToOpen(const FrameContext& context);
/// Of the window: opening, theme, size of text, palette, pictures, help, end.
ActionGroup WindowActions();

}  // namespace plumbline
