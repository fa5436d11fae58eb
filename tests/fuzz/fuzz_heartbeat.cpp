// Arbitrary bytes as heartbeats and as the user data of participants. Accepted bytes are written again as the
// same bytes or values.
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/control/control.h"
#include "core/discovery/heartbeat.h"
#include "core/discovery/participant_data.h"

namespace sft::core {
namespace {

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);  // libFuzzer reports the exception as a crash
}

void check_heartbeat(const std::vector<std::byte>& datagram) {
  const auto heartbeat = decode_heartbeat(datagram);
  if (!heartbeat) return;
  const HeartbeatDatagram written = encode(*heartbeat);
  require(std::vector(written.begin(), written.end()) == datagram, "it is written in the same way");
}

/// The text may contain letters without meaning, so only the values that were read are compared.
void check_user_data(const std::string& text) {
  const auto data = parse_participant_data(text);
  const auto release = other_release(text);
  require(!data || !release, "a participant has one release");
  require(!release || *release != control_protocol_version(), "ours is no other release");
  if (!data) return;
  require(data->process != 0, "it names a process");
  require(parse_participant_data(to_text(*data)) == data, "what is written again is the same");
}

}  // namespace
}  // namespace sft::core

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  sft::core::check_heartbeat({bytes.begin(), bytes.end()});
  sft::core::check_user_data({reinterpret_cast<const char*>(data), size});
  return 0;
}
