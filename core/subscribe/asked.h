// A subscriber's request, as its samples are delivered under it. Immutable.
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
  /// Takes just that out of a sample that has more. Null: samples are delivered as they come.
  std::unique_ptr<const detail::ProjectionPlan> plan{};
  bool from_network = false;  ///< also out of samples that came by UDP: the selection has parts
  /// The parts are of recorded channels. Samples that have more are delivered as they come.
  std::optional<detail::ChannelsSent> recorded_channels{};
};

/// `as_remote`: samples in shared memory are reduced to what a reader on another host would get, also if
/// whole fields are asked for. `recorder`: the selection is what was recorded; null: it is declared.
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
