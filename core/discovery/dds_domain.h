// Domains of Cyclone DDS, and the destination of its log, of which a process has only one.
#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <memory>
#include <string>
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

/// A Cyclone domain for one participant, with a domain number that nothing else in this process uses. The
/// domain is deleted when its owner releases it. The release waits for Cyclone's threads. So the owner must
/// delete the participant first, and must not release the domain in a listener, or while it holds a lock that
/// listeners take.
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
};

/// Returns a new domain for the plan. Errors that Cyclone logs are added to `complaints`.
Result<std::shared_ptr<const CycloneDomain>> cyclone_domain(const DomainPlan& plan,
                                                            std::vector<std::string>& complaints);

/// Returns true if the program itself uses that domain in this process.
bool program_has_opened(std::uint32_t domain);

}  // namespace sft::core
