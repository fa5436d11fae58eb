// Arbitrary bytes as bodies of records and reports, after one octet that names the kind. Nothing is read
// beyond the end. An accepted record or report is within the limits, and is written again with the same
// values.
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

#include "core/control/record_body.h"

namespace sft::core {
namespace {

using Bytes = std::vector<std::byte>;

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);  // libFuzzer reports the exception as a crash
}

template <class What>
bool is_refused(const Result<What>& read) {
  if (read) return false;
  require(read.error().code == Errc::malformed, "bytes are malformed, if anything");
  require(!read.error().message.empty(), "an error says what is wrong");
  return true;
}

/// The decoder drops useless addresses and corrects names, so only the values that were read are compared.
void check_endpoint(const Bytes& bytes) {
  const Result<Endpoint> read = endpoint_in(bytes);
  if (is_refused(read)) return;
  require(read->id != 0 && !read->topic.empty() && read->request.reader == read->id, "it is an endpoint");
  require(
      read->addresses.size() <= addresses_max && read->type_description.size() <= type_description_bytes_max,
      "there is room for no more");
  const Bytes written = to_bytes(*read);
  require(written.size() <= record_bytes_max, "a record has room for it");
  require(endpoint_in(written) == *read, "what is written again is the same");
}

void check_request(const Bytes& bytes) {
  const Result<Request> read = request_in(bytes);
  if (is_refused(read)) return;
  require(read->reader != 0 && read->sequence <= request_sequence_max, "it is a request");
  require(read->mask_words.size() <= mask_words_max && read->parts.size() <= wants_bytes_max,
          "there is room for no more fields");
  for (const auto* const writers : {&read->listening, &read->attached, &read->begun})
    require(writers->size() <= writers_per_reader_max, "there is room for no more writers");
  require(to_bytes(*read) == bytes, "it is written in the same way");
}

void check_inquiry(const Bytes& bytes) {
  const Result<Inquiry> read = inquiry_in(bytes);
  if (is_refused(read)) return;
  require(to_bytes(*read) == bytes, "it is written in the same way");
}

void check_report(const Bytes& bytes) {
  const Result<NodeReport> read = report_in(bytes);
  if (is_refused(read)) return;
  require(report_in(to_bytes(*read)) == *read, "what is written again is the same");
}

/// The bytes are read from memory of exactly their size, so that the address sanitizer notices the first
/// byte beyond it.
void check(std::span<const std::byte> input) {
  if (input.empty()) return;
  const Bytes body(input.begin() + 1, input.end());
  switch (std::to_integer<unsigned>(input[0]) % 4) {
    case 0:
      return check_endpoint(body);
    case 1:
      return check_request(body);
    case 2:
      return check_inquiry(body);
    default:
      return check_report(body);
  }
}

}  // namespace
}  // namespace sft::core

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  sft::core::check(std::as_bytes(std::span(data, size)));
  return 0;
}
