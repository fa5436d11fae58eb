// Converts between the core's control structs and those that Cyclone's compiler made of sft_control.idl. What
// comes from outside is checked here: versions, roles, names.
#pragma once

#include <cstdint>
#include <string>
#include <variant>

#include "core/control/control.h"
#include "sft/result.h"
#include "sft_control.h"

namespace sft::core {

/// Views into what is given and `storage`, valid as long as these; nothing is to be freed.
struct ControlStorage {
  std::vector<sft_control_UdpLocator> addresses;
  std::vector<sft_control_Progress> progress;
  std::vector<sft_control_Account> accounts;
  std::vector<std::byte> wants;
};
sft_control_Request to_dds(const Request& request, ControlStorage& storage);
/// The sample has no key yet: the link that writes it sets its own.
sft_control_Endpoint to_dds(const Endpoint& endpoint, ControlStorage& storage);

/// The message of a reader's node on the topic sft_reader is one of these.
enum class ReaderPart : std::uint8_t { announcement, request };
sft_control_ReaderWord in_word(sft_control_Endpoint& announcement);
/// `key` is the key under which the reader is announced.
sft_control_ReaderWord in_word(sft_control_Request& request, std::uint64_t key);

sft_control_Assertion to_dds(const Assertion& assertion, ControlStorage& storage);

Result<Assertion> from_dds(const sft_control_Assertion& assertion);
Result<Request> from_dds(const sft_control_Request& request);
Result<Endpoint> from_dds(const sft_control_Endpoint& endpoint);
/// Fails if the word contains anything else than its part names.
Result<std::variant<Endpoint, Request>> from_dds(const sft_control_ReaderWord& word);

}  // namespace sft::core
