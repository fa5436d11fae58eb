// Cyclone DDS has these once in a process, though several nodes live in it: domains, and a destination of its
// log.
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

  /// All in one line.
  std::string text() const;
  const std::vector<std::string>& errors() const { return errors_; }

 private:
  static void on_message(void* nothing, const dds_log_data_t* message);

  CycloneMessages* const outer_;
  std::vector<std::string> errors_;
  std::vector<std::string> warnings_;
};

/// A Cyclone domain for one link, under a number inside of this process that nobody else uses. It ends with
/// its last owner, which must have deleted its own participant, and waits for Cyclone's threads: not to be
/// let go of in a listener, or under a lock that listeners take.
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
  bool is_secured = false;  ///< the configuration has DDS Security, which can name few numbers
  ThreadSettings threads{};
  /// The index of the interface. Multicast groups that sockets have joined end with a card, also if one comes
  /// back that has the same name and address.
  unsigned index = 0;
  friend bool operator<(const DomainPlan& a, const DomainPlan& b) {
    const auto key = [](const DomainPlan& plan) {
      const ThreadSettings& t = plan.threads;
      return std::tie(plan.config, plan.is_secured, t.cpus, t.policy, t.priority, t.name_prefix, plan.index);
    };
    return key(a) < key(b);
  }
};

/// Callers in a process that ask for the same share one domain. Complaints of Cyclone are added to
/// `complaints`. `instead_of`: one that is not to be used any more, or null.
Result<std::shared_ptr<const CycloneDomain>> cyclone_domain(const DomainPlan& plan,
                                                            const CycloneDomain* instead_of,
                                                            std::vector<std::string>& complaints);

/// True if the program itself uses that domain in this process.
bool program_has_opened(std::uint32_t domain);

}  // namespace sft::core
