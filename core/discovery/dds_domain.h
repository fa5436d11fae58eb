// What Cyclone DDS has only once in a process, however many nodes use it: the domains, and a destination of
// its log.
#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "sft/options.h"
#include "sft/result.h"

namespace sft::core {

/// Collects what Cyclone logs in this thread, while this object lives. From the first such object on,
/// anything else that Cyclone logs in this process is dropped: it would go to standard error, and the library
/// never prints.
class CycloneMessages {
 public:
  CycloneMessages();
  ~CycloneMessages();
  CycloneMessages(const CycloneMessages&) = delete;
  CycloneMessages& operator=(const CycloneMessages&) = delete;

  /// Returns all messages in one line.
  std::string text() const;
  const std::vector<std::string>& errors() const { return errors_; }

 private:
  static void on_message(void* nothing, const dds_log_data_t* message);

  CycloneMessages* const outer_;
  std::vector<std::string> errors_;
  std::vector<std::string> warnings_;
};

/// A Cyclone domain for one link, under a domain number that nothing else in this process uses. It is deleted
/// when its last owner releases it, which waits for Cyclone's threads. That owner must have deleted its own
/// participant. It must not release the domain in a listener, or under a lock that listeners take.
class CycloneDomain {
 public:
  CycloneDomain(std::uint32_t id, dds_entity_t entity) : id_(id), entity_(entity) {}
  ~CycloneDomain() { dds_delete(entity_); }
  CycloneDomain(const CycloneDomain&) = delete;
  CycloneDomain& operator=(const CycloneDomain&) = delete;

  std::uint32_t id() const { return id_; }

 private:
  const std::uint32_t id_;
  const dds_entity_t entity_;
};

struct DomainPlan {
  std::string config;
  bool is_secured = false;  ///< the configuration has DDS Security, which allows few domain numbers
  ThreadSettings threads{};
  /// The index of the interface. When an interface is removed, sockets lose the multicast groups that they
  /// joined there. An interface that comes back with the same name and address has another index.
  unsigned index = 0;
  friend bool operator<(const DomainPlan& a, const DomainPlan& b) {
    const auto key = [](const DomainPlan& plan) {
      const ThreadSettings& t = plan.threads;
      return std::tie(plan.config, plan.is_secured, t.cpus, t.policy, t.priority, t.name_prefix, plan.index);
    };
    return key(a) < key(b);
  }
};

/// Returns a domain for the plan. Callers in a process with equal plans share one. Errors that Cyclone logs
/// are added to `complaints`. `instead_of`: a domain that must not be shared any more, or null.
Result<std::shared_ptr<const CycloneDomain>> cyclone_domain(const DomainPlan& plan,
                                                            const CycloneDomain* instead_of,
                                                            std::vector<std::string>& complaints);

/// Returns true if the program itself uses that domain in this process.
bool program_has_opened(std::uint32_t domain);

}  // namespace sft::core
