// The bodies of records and reports as they come from the control topics, with whatever in them: nothing is
// read behind their ends, what is taken is within the bounds, and is written again as it was.
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

#include "core/control/record_body.h"

namespace sft::core {
namespace {

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);  // libFuzzer reports it as a crash
}

/// `read` is one of the functions of record_body.h.
template <class What>
void check(std::span<const std::byte> bytes, Result<What> (*read)(std::span<const std::byte>)) {
  const Result<What> taken = read(bytes);
  if (!taken) return require(!taken.error().message.empty(), "an error says what is wrong");
  const std::vector<std::byte> written = to_bytes(*taken);
  require(written.size() <= record_bytes_max, "there is room for no more");
  const Result<What> again = read(written);
  require(again && *again == *taken, "what is written again is the same");
}

}  // namespace
}  // namespace sft::core

/// The first octet says what the others are.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sft::core;
  if (size == 0) return 0;
  const std::vector<std::byte> body(reinterpret_cast<const std::byte*>(data) + 1,
                                    reinterpret_cast<const std::byte*>(data) + size);
  switch (data[0] % 4) {
    case 0:
      check<Endpoint>(body, &endpoint_in);
      break;
    case 1:
      check<Request>(body, &request_in);
      break;
    case 2:
      check<Inquiry>(body, &inquiry_in);
      break;
    default:
      check<NodeReport>(body, &report_in);
  }
  return 0;
}
