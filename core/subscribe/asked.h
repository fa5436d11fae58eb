// A request of a subscriber, with what is needed to deliver samples under it. Immutable.
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
  Selection selection;  ///< closed, without a rate
  /// Reduces a sample that has more than the selection. Null: samples are delivered as they come.
  std::unique_ptr<const detail::ProjectionPlan> plan{};
  bool from_network = false;  ///< samples that came by UDP are reduced, too, because the selection has parts
  /// Set if the parts are those of recorded channels. Samples that have more are then delivered as they come.
  std::optional<detail::ChannelsSent> recorded_channels{};
};

/// `as_remote`: samples in shared memory are reduced to what a reader on another host would get, even if the
/// selection has only whole fields. `recorder` has recorded the selection; null: it is declared.
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
