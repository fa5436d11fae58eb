// Decides when a node has a participant for unmodified nodes of DDS and ROS 2: while its publishers may have
// such readers, and on `automatic` only while there are such nodes. The agent's.
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "core/discovery/discovery.h"
#include "core/platform/clock.h"
#include "core/platform/retry.h"
#include "core/report/node_log.h"
#include "core/vanilla/vanilla_domain.h"
#include "sft/options.h"

namespace sft::core {

class VanillaAccess {
 public:
  /// After the last such node has gone the participant stays so long: nodes restart, and tools come and go.
  static constexpr std::chrono::seconds kept{30};

  struct Setup {
    NodeOptions::VanillaDds choice = NodeOptions::VanillaDds::never;
    VanillaPlan plan{};
    ThreadSettings sender{};  ///< of the threads that hand samples over
    std::function<Result<std::shared_ptr<VanillaDomain>>(const VanillaPlan&)> open = &VanillaDomain::of;
    std::function<bool(std::uint32_t domain)> program_speaks = &program_speaks_dds;
    /// Called by any thread when readers of some publisher have come or gone: posts and returns.
    std::function<void()> readers_changed{};
  };
  VanillaAccess(Setup setup, NodeLog& log) : setup_(std::move(setup)), log_(log) {}

  /// `heard`: the nodes of DDS that the links hear. Returns true if the domain is another one than before, or
  /// has other readers.
  bool look(const Discovery::Vanilla& heard, bool has_publishers, Time now);
  /// When to look again at the latest; Time::max() if nothing changes by itself.
  Time next_look() const { return next_look_; }

  /// Null while there is none.
  const std::shared_ptr<VanillaDomain>& domain() const { return domain_; }
  const Setup& setup() const { return setup_; }

 private:
  bool is_wanted(const Discovery::Vanilla& heard, Time now);
  bool may_serve(const Discovery::Vanilla& heard);
  bool open(Time now);

  const Setup setup_;
  NodeLog& log_;
  std::shared_ptr<VanillaDomain> domain_;
  Retry opening_;
  Time heard_at_{};                  ///< the last time; Time{}: never
  std::uint64_t changes_ = 0;        ///< of the readers of the domain, as of the last look
  std::uint64_t came_ = 0;           ///< as of the last look at the program
  bool program_speaks_dds_ = false;  ///< as of that look
  Time next_look_ = Time::max();
};

}  // namespace sft::core
