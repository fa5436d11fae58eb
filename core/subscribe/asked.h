// A request of a subscriber, with the data that are needed to deliver samples for it. Immutable.
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "core/subscribe/recorder.h"
#include "sft/detail/access_log.h"
#include "sft/detail/project.h"
#include "sft/selection.h"
#include "sft/type_support.h"

namespace sft::core {

struct Asked {
  Selection selection;  ///< the selection, which is closed and has no rate
  /// The plan to reduce samples that have more than the selection. Null: samples are delivered unchanged.
  std::unique_ptr<const detail::ProjectionPlan> plan{};
  /// True: samples that came by UDP are reduced, too, because the selection has parts.
  bool from_network = false;
  /// Set if the parts are those of recorded channels. In this case samples with more channels are delivered
  /// unchanged.
  std::optional<detail::ChannelsSent> recorded_channels{};
};

/// Makes the request. `as_remote` means that samples in shared memory are reduced as on another host, even if
/// the selection has only whole fields. `recorder` is the recorder of the selection, or null if it is
/// declared.
inline std::shared_ptr<const Asked> make_asked(const TypeSupport& type, Selection selection, bool as_remote,
                                               const Recorder* recorder) {
  auto asked = std::make_shared<Asked>();
  asked->from_network = !selection.parts().empty() && recorder == nullptr;
  if (recorder != nullptr) asked->recorded_channels = recorder->sent_for(selection);
  if (as_remote || asked->from_network)
    asked->plan = std::make_unique<const detail::ProjectionPlan>(type, selection);
  asked->selection = std::move(selection);
  return asked;
}

}  // namespace sft::core
