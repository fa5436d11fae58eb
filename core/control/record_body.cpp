#include "core/control/record_body.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <string_view>
#include <type_traits>
#include <utility>

#include "core/names/names.h"
#include "sft_control.h"

namespace sft::core {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

/// Writes members one after the other.
class BodyWriter {
 public:
  template <class Number>
  void number(const Number& number) {
    const auto* const first = reinterpret_cast<const std::byte*>(&number);
    bytes_.insert(bytes_.end(), first, first + sizeof number);
  }
  void flag(const bool& flag) { number(static_cast<std::uint8_t>(flag)); }
  void duration(const std::chrono::nanoseconds& time) { number(time.count()); }
  void text(const std::string& text) {
    const auto size = static_cast<std::uint8_t>(std::min(text.size(), name_bytes_max));
    number(size);
    const auto* const first = reinterpret_cast<const std::byte*>(text.data());
    bytes_.insert(bytes_.end(), first, first + size);
  }
  /// Writes a list; `item(value)` writes one value. If a list is too long, only its first `most` values are
  /// written.
  template <class Value, class Item>
  void list(const std::vector<Value>& values, std::size_t most, Item item) {
    const auto size = static_cast<std::uint32_t>(std::min(values.size(), most));
    number(size);
    for (std::size_t i = 0; i < size; ++i) item(values[i]);
  }

  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

/// Reads bytes that BodyWriter has written. If the bytes end too early, the member that is incomplete and
/// all later members keep their previous values.
class BodyReader {
 public:
  explicit BodyReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <class Number>
  void number(Number& number) {
    if (const auto octets = take(sizeof number); !octets.empty())
      std::memcpy(&number, octets.data(), sizeof number);
  }
  void flag(bool& flag) {
    std::uint8_t octet = 0;
    number(octet);
    is_sound_ &= octet <= 1;
    flag = octet == 1;
  }
  void duration(std::chrono::nanoseconds& time) {
    std::int64_t count = 0;
    number(count);
    is_sound_ &= count >= 0;
    time = std::chrono::nanoseconds(count);
  }
  void text(std::string& text) {
    std::uint8_t size = 0;
    number(size);
    const auto octets = take(size);
    text.assign(reinterpret_cast<const char*>(octets.data()), octets.size());
  }
  template <class Value, class Item>
  void list(std::vector<Value>& values, std::size_t most, Item item) {
    std::uint32_t size = 0;
    number(size);
    is_sound_ &= size <= most;
    for (std::size_t i = 0; i < size && is_sound_; ++i) item(values.emplace_back());
  }

  /// Returns true if the bytes contained all members and nothing else.
  bool is_complete() const { return is_sound_ && rest_.empty(); }

 private:
  /// Returns the next `size` octets. If fewer octets are left, the result is empty.
  std::span<const std::byte> take(std::size_t size) {
    is_sound_ &= size <= rest_.size();
    if (!is_sound_) return {};
    const auto taken = rest_.first(size);
    rest_ = rest_.subspan(size);
    return taken;
  }

  std::span<const std::byte> rest_;
  bool is_sound_ = true;
};

// Each of these functions lists the members of one type in the order of the format. The lists are used for
// both writing and reading.

template <class Body, class AnyAddress>
void each_member_of_address(Body& body, AnyAddress& address) {
  for (auto& octet : address.ip.bytes) body.number(octet);
  body.number(address.port);
  body.number(address.receive_buffer_bytes);
  body.flag(address.wireless);
}

template <class Body, class AnyQos>
void each_member_of_qos(Body& body, AnyQos& qos) {
  body.number(qos.reliability);
  body.number(qos.durability);
  body.number(qos.liveliness);
  body.duration(qos.deadline);
  body.duration(qos.liveliness_lease);
  body.duration(qos.lifespan);
  body.number(qos.history_depth);
}

template <class Body, class AnyEndpoint>
void each_member(Body& body,
                 AnyEndpoint& endpoint) requires std::is_same_v<std::remove_const_t<AnyEndpoint>, Endpoint> {
  body.number(endpoint.id);
  body.number(endpoint.role);
  body.number(endpoint.node_id);
  body.text(endpoint.node);
  body.text(endpoint.topic);
  body.text(endpoint.given_topic);
  body.text(endpoint.type_name);
  body.number(endpoint.type_hash);
  body.list(endpoint.type_description, type_description_bytes_max, [&](auto& octet) { body.number(octet); });
  for (auto& octet : endpoint.host.bytes) body.number(octet);
  body.text(endpoint.memory_failure);
  body.number(endpoint.network);
  body.flag(endpoint.may_use_memory);
  body.flag(endpoint.may_use_network);
  body.list(endpoint.addresses, addresses_max, [&](auto& address) { each_member_of_address(body, address); });
  body.number(endpoint.doorbell.page);
  body.number(endpoint.doorbell.slot);
  body.number(endpoint.max_sample_bytes);
  body.flag(endpoint.waits);
  each_member_of_qos(body, endpoint.qos);
}

template <class Body, class AnyRequest>
void each_member(Body& body,
                 AnyRequest& request) requires std::is_same_v<std::remove_const_t<AnyRequest>, Request> {
  const auto number = [&](auto& one) { body.number(one); };
  body.number(request.reader);
  body.number(request.sequence);
  body.list(request.mask_words, mask_words_max, number);
  body.number(request.min_period_us);
  body.list(request.parts, wants_bytes_max, number);
  body.list(request.listening, writers_per_reader_max, number);
  body.list(request.attached, writers_per_reader_max, number);
  body.list(request.begun, writers_per_reader_max, number);
}

template <class Body, class AnyInquiry>
void each_member(Body& body,
                 AnyInquiry& inquiry) requires std::is_same_v<std::remove_const_t<AnyInquiry>, Inquiry> {
  body.text(inquiry.topic);
  body.flag(inquiry.wants_accounts);
}

/// Lists the members of an account. An account is transmitted with the counts of the reporting side only.
template <class Body, class AnyAccount>
void each_member_of_account(Body& body, AnyAccount& account) {
  body.number(account.id.pair.writer);
  body.number(account.id.pair.reader);
  body.number(account.id.said_by);
  if (account.id.said_by == Role::writer) {
    auto& counts = account.by_writer;
    for (auto* const count :
         {&counts.sent, &counts.withheld, &counts.dropped, &counts.retained, &counts.bytes_sent,
          &counts.bytes_saved, &counts.diverted, &counts.too_large_bytes, &counts.chunk_bytes})
      body.number(*count);
  } else {
    body.number(account.by_reader.received);
    body.number(account.by_reader.lost);
  }
}

template <class Body, class AnyReport>
void each_member(Body& body,
                 AnyReport& report) requires std::is_same_v<std::remove_const_t<AnyReport>, NodeReport> {
  body.list(report.living, living_max, [&](auto& writer) { body.number(writer); });
  body.list(report.progress, progress_max, [&](auto& progress) {
    body.number(progress.writer);
    body.number(progress.samples);
    body.number(progress.bytes);
  });
  body.list(report.accounts, accounts_max, [&](auto& account) { each_member_of_account(body, account); });
}

template <class What>
std::vector<std::byte> written(const What& what) {
  BodyWriter body;
  each_member(body, what);
  return body.take();
}

template <class What>
Result<What> read(std::span<const std::byte> bytes, const char* what) {
  What result;
  BodyReader body(bytes);
  each_member(body, result);
  if (body.is_complete()) return result;
  return fail(Errc::malformed, std::string(what) + " of " + std::to_string(bytes.size()) +
                                   " bytes that are cut, too many, or out of bounds");
}

/// Returns the reason why the endpoint is invalid, or an empty text if it is valid.
std::string fault_of(const Endpoint& endpoint) {
  const bool has_known_qos = endpoint.qos.reliability <= Reliability::reliable &&
                             endpoint.qos.durability <= Durability::transient_local &&
                             endpoint.qos.liveliness <= Liveliness::manual_by_topic;
  if (!has_known_qos) return "of unknown quality of service";
  if (endpoint.id == 0 || endpoint.role > Role::reader) return "without id or role";
  const auto check = [](const char* what, std::string_view name, std::string_view fault) {
    return fault.empty() ? ""
                         : std::string("whose ") + what + " " + in_quotes(name) + " " + std::string(fault);
  };
  std::string fault = check("topic", endpoint.topic, fault_of_announced_topic(endpoint.topic));
  for (const auto& [what, name] :
       {std::pair("program's topic", &endpoint.given_topic), std::pair("node name", &endpoint.node)}) {
    if (fault.empty() && !name->empty()) fault = check(what, *name, fault_of_name(*name));
  }
  if (fault.empty()) fault = check("type name", endpoint.type_name, fault_of_name(endpoint.type_name));
  return fault;
}

bool is_of_use(const UdpAddress& address) {
  return address.port != 0 && !address.ip.is_any() && !address.ip.is_multicast();
}

}  // namespace

std::vector<std::byte> to_bytes(const Endpoint& endpoint) {
  if (endpoint.type_description.size() <= type_description_bytes_max) return written(endpoint);
  Endpoint undescribed = endpoint;
  undescribed.type_description.clear();
  return written(undescribed);
}

std::vector<std::byte> to_bytes(const Request& request) {
  if (request.parts.size() <= wants_bytes_max) return written(request);
  Request whole = request;
  whole.parts.clear();
  return written(whole);
}

std::vector<std::byte> to_bytes(const Inquiry& inquiry) { return written(inquiry); }

std::vector<std::byte> to_bytes(const NodeReport& report) { return written(report); }

Result<Endpoint> endpoint_in(std::span<const std::byte> bytes) {
  Result<Endpoint> endpoint = read<Endpoint>(bytes, "an endpoint");
  if (!endpoint) return endpoint;
  if (const std::string fault = fault_of(*endpoint); !fault.empty())
    return fail(Errc::malformed, "an endpoint " + fault);
  endpoint->topic = without_slash(std::string(endpoint->topic));
  // This text is only for people. If it is invalid, for example because it was cut within a character, the
  // endpoint is accepted without it.
  if (!fault_of_name(endpoint->memory_failure).empty()) endpoint->memory_failure.clear();
  std::erase_if(endpoint->addresses, [](const UdpAddress& one) { return !is_of_use(one); });
  endpoint->request.reader = endpoint->id;
  return endpoint;
}

Result<Request> request_in(std::span<const std::byte> bytes) {
  Result<Request> request = read<Request>(bytes, "a request");
  if (request && request->reader == 0) return fail(Errc::malformed, "a request of no subscriber");
  if (request && request->sequence > request_sequence_max)
    return fail(Errc::malformed, "a request with the sequence " + std::to_string(request->sequence) +
                                     ", which no subscriber comes to");
  return request;
}

Result<Inquiry> inquiry_in(std::span<const std::byte> bytes) {
  Result<Inquiry> inquiry = read<Inquiry>(bytes, "an inquiry");
  if (!inquiry || inquiry->topic.empty()) return inquiry;
  if (const auto fault = fault_of_announced_topic(inquiry->topic); !fault.empty())
    return fail(Errc::malformed, "an inquiry whose topic " + std::string(fault));
  return inquiry;
}

Result<NodeReport> report_in(std::span<const std::byte> bytes) {
  Result<NodeReport> report = read<NodeReport>(bytes, "a report");
  const auto is_of_no_side = [](const Account& account) { return account.id.said_by > Role::reader; };
  if (report && std::ranges::any_of(report->accounts, is_of_no_side))
    return fail(Errc::malformed, "a report with an account of neither publisher nor subscriber");
  return report;
}

std::uint32_t control_protocol_version() { return sft_control_protocol_version; }

}  // namespace sft::core
