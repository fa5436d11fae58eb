// The parts of Cyclone DDS that a process has only once, whatever the number of its nodes: the domains, and
// the destination of the log.
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

/// Collects what Cyclone logs in this thread, while this object lives. Once the first such object exists,
/// all other messages that Cyclone logs in this process are dropped. Cyclone would print them to standard
/// error, and the library must never print.
class CycloneMessages {
 public:
  CycloneMessages();
  ~CycloneMessages();
  CycloneMessages(const CycloneMessages&) = delete;
  CycloneMessages& operator=(const CycloneMessages&) = delete;

  /// Returns all messages, joined in one line.
  std::string text() const;
  const std::vector<std::string>& errors() const { return errors_; }

 private:
  static void on_message(void* nothing, const dds_log_data_t* message);

  CycloneMessages* const outer_;
  std::vector<std::string> errors_;
  std::vector<std::string> warnings_;
};

/// A Cyclone domain for one link, with a domain number that nothing else in this process uses. The domain
/// is deleted when its last owner releases it. The release waits for Cyclone's threads. So an owner must
/// delete its own participant first, and must not release the domain in a listener, or while it holds a
/// lock that listeners take.
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
  bool is_secured = false;  ///< the configuration has DDS Security, which restricts the domain numbers to a
                            ///< few
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

/// Returns a domain for the plan. Callers in this process with equal plans share a domain. Errors that
/// Cyclone logs are added to `complaints`. `instead_of`: a domain that must not be returned again, or null.
Result<std::shared_ptr<const CycloneDomain>> cyclone_domain(const DomainPlan& plan,
                                                            const CycloneDomain* instead_of,
                                                            std::vector<std::string>& complaints);

/// Returns true if the program itself uses that domain in this process.
bool program_has_opened(std::uint32_t domain);

}  // namespace sft::core
