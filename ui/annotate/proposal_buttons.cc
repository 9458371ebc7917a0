// SPDX-License-Identifier: Apache-2.0
#include "ui/annotate/proposal_buttons.h"

#include "ui/framework/widgets.h"

namespace plumbline {

ProposalAnswer DrawProposalButtons(const FrameContext& context, const char* accept,
                                   const char* accept_help, bool can_accept,
                                   const char* discard_help) {
  ProposalAnswer answer = ProposalAnswer::kNone;
  ImGui::BeginDisabled(!can_accept);
  ImGui::PushStyleColor(ImGuiCol_Button, colors::kAccentDim);
  if (Button(context, "proposal.accept", accept, accept_help)) answer = ProposalAnswer::kAccept;
  ImGui::PopStyleColor();
  ImGui::EndDisabled();
  ImGui::SameLine();
  if (Button(context, "proposal.cancel", "Discard", discard_help))
    answer = ProposalAnswer::kDiscard;
  return answer;
}

}  // namespace plumbline
