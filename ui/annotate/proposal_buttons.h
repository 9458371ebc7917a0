// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ui/framework/frame_context.h"

namespace plumbline {

enum class ProposalAnswer { kNone, kAccept, kDiscard };

/// The buttons under a proposal, proposal.accept and proposal.cancel, as a row that others may
/// continue. Panels post what the answer means.
/// @param accept  Label of the first one.
/// @param can_accept  False while there is nothing to accept yet: it is dimmed.
ProposalAnswer DrawProposalButtons(const FrameContext& context, const char* accept,
                                   const char* accept_help, bool can_accept,
                                   const char* discard_help);

}  // namespace plumbline
