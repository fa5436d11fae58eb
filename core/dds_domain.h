// What Cyclone DDS has once in a process, though several nodes live in it: a configuration for each domain,
// and a destination of what it logs.
#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/dds_config.h"
#include "sft/typesupport/result.h"

namespace sft::core {

/// What Cyclone logs in this thread, while it lives. From the first one on, what it logs otherwise in this
/// process goes nowhere: it would go to standard error, and the library never prints.
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

/// Makes sure that the domain exists with this configuration. It stays until the process ends: Cyclone cannot
/// be told to end a domain without ending what the program itself may have made in it. So it is an error if
/// another node of this process opened it with another configuration, and a warning is added to `config` if
/// it was not SFT that opened it.
Result<void> open_dds_domain(std::uint32_t domain, DdsConfig& config);

}  // namespace sft::core
