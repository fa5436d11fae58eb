// A feed provides the samples of one selection of a subscriber. Each selection is a separate endpoint, with
// its own request, ports, order of samples, and counts. Most subscribers have one selection.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <utility>

#include "core/control/control.h"
#include "core/subscribe/recorder.h"
#include "core/subscribe/subscriber_ports.h"
#include "core/sync/mutex.h"
#include "sft/qos.h"
#include "sft/requirements.h"
#include "sft/result.h"
#include "sft/selection.h"
#include "sft/status.h"
#include "sft/type_support.h"

namespace sft::core {

class Feed {
 public:
  struct Spec {
    EndpointId id = 0;
    /// The declared selection, closed and without a rate. If fields are recorded, it is the selection that is
    /// requested at first.
    Selection selection{};
    /// The least time between two samples at its maximum rate; 0: all samples.
    std::uint32_t min_period_us = 0;
    Qos qos{};  ///< the QoS that the subscriber requests
    /// Called by any thread when the needs of the subscriber have changed. Posts to the agent, and returns.
    std::function<void()> changed = [] {};
  };
  /// The settings that all feeds of a subscriber share.
  struct Common {
    const TypeSupport& type;
    std::string_view topic;
    /// The longest time to wait for a diverted sample (Intake::Options).
    std::chrono::nanoseconds timeout{0};
    std::uint32_t depth = 0;         ///< SubscriberOptions::depth
    std::uint32_t memory_depth = 0;  ///< the part of `depth` that shared memory keeps; 0: all
    bool as_remote = false;          ///< SubscriberOptions::Recording::as_remote
    bool reports_asked = false;      ///< see SubscriberPorts
    Recorder* recorder = nullptr;    ///< null: the selection is declared
  };

  /// The objects that `common` names must outlive this object.
  Feed(Spec spec, const Common& common);

  const Spec& spec() const { return spec_; }
  SubscriberPorts& ports() { return ports_; }

  /// Returns the selection that the subscriber needs at present, declared or recorded. It is closed, and has
  /// no rate. Any thread.
  Selection required() const SFT_EXCLUDES(mutex_);
  // These do what the functions of the class Subscriber with these names do. Any thread.
  Result<void> set_max_rate_hz(double max_rate_hz);
  Result<void> set_selection(const Selection& other) SFT_EXCLUDES(mutex_);
  SubscriberStatus status();
  Requirements requirements();

  // The functions for the agent's thread.
  /// Counts a sample that has waited long for the callback, while callbacks of other subscribers were
  /// running.
  void waited_long() { long_waits_.fetch_add(1, std::memory_order_relaxed); }
  /// Sets the request that is in force from now on, and its number.
  void requests(Selection selection, std::uint64_t sequence);

 private:
  std::shared_ptr<const Asked> asked(Selection selection) const {
    return make_asked(common_.type, std::move(selection), common_.as_remote, common_.recorder);
  }

  const Spec spec_;
  const Common common_;
  mutable Mutex mutex_;  // held for a copy of the selection
  Selection declared_ SFT_GUARDED_BY(mutex_);
  SubscriberPorts ports_;
  std::atomic<std::uint64_t> long_waits_{0};
};

}  // namespace sft::core
