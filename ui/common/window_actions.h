// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ui/framework/actions.h"

namespace plumbline {

/// Of the 3-D view of whichever workspace shows.
ActionGroup ViewActions();
/// Of the window: theme, size of text, palette, pictures, help, end.
ActionGroup WindowActions();

}  // namespace plumbline
