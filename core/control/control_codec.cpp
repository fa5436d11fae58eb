#include "core/control/control_codec.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include "core/control/names.h"
#include "core/control/wants.h"

namespace sft::core {

namespace {

dds_sequence_unsigned_long_long borrow(const std::vector<std::uint64_t>& values, std::size_t most) {
  const auto n = static_cast<std::uint32_t>(std::min(values.size(), most));
  return {n, n, const_cast<std::uint64_t*>(values.data()), false};
}

dds_sequence_octet borrow(const std::vector<std::byte>& bytes, std::size_t most) {
  const auto n = static_cast<std::uint32_t>(bytes.size() > most ? 0 : bytes.size());
  return {n, n, reinterpret_cast<std::uint8_t*>(const_cast<std::byte*>(bytes.data())), false};
}

std::vector<std::byte> copy(const dds_sequence_octet& s) {
  const auto* first = reinterpret_cast<const std::byte*>(s._buffer);
  return {first, first + s._length};
}

std::vector<std::uint64_t> copy(const dds_sequence_unsigned_long_long& s) {
  return {s._buffer, s._buffer + s._length};
}

template <std::size_t N>
void put(char (&to)[N], const std::string& text) {
  const std::size_t n = std::min(text.size(), N - 1);
  std::memcpy(to, text.data(), n);
  to[n] = '\0';
}

using DigestOctets = std::uint8_t[3];

void put_digest(DigestOctets& to, std::uint32_t digest) {
  for (std::size_t i = 0; i < std::size(to); ++i) to[i] = static_cast<std::uint8_t>(digest >> (8 * i));
}

std::uint32_t digest_in(const DigestOctets& octets) {
  std::uint32_t digest = 0;
  for (std::size_t i = 0; i < std::size(octets); ++i) digest |= std::uint32_t{octets[i]} << (8 * i);
  return digest;
}

tl::unexpected<Error> wrong_version(unsigned version) {
  return fail(Errc::malformed, "a control sample of protocol version " + std::to_string(version) +
                                   ", this is " + std::to_string(sft_control_protocol_version));
}

tl::unexpected<Error> beyond_all(std::uint64_t sequence) {
  return fail(Errc::malformed,
              "a request with the sequence " + std::to_string(sequence) + ", which no reader comes to");
}

Result<void> check_names(const sft_control_Endpoint& in) {
  const auto check = [](const char* what, std::string_view name, std::string_view fault) -> Result<void> {
    if (fault.empty()) return {};
    return fail(Errc::malformed,
                std::string("an endpoint whose ") + what + " " + in_quotes(name) + " " + std::string(fault));
  };
  Result<void> checked = check("topic", in.topic, fault_of_topic(in.topic));
  const bool has_given = in.given_topic[0] != '\0';
  if (checked && has_given) checked = check("program's topic", in.given_topic, fault_of_name(in.given_topic));
  if (checked) checked = check("type name", in.type_name, fault_of_name(in.type_name));
  const bool has_node = in.node[0] != '\0';
  if (checked && has_node) checked = check("node name", in.node, fault_of_name(in.node));
  return checked;
}

sft_control_UdpLocator to_dds(const UdpAddress& address) {
  sft_control_UdpLocator out{};
  out.family = address.ip.is_ipv4() ? 4 : 6;
  out.wireless = address.wireless;
  std::ranges::copy(address.ip.bytes, out.address);
  out.port = address.port;
  out.receive_buffer_bytes = address.receive_buffer_bytes;
  return out;
}

/// Empty where it is nothing that one socket could be reached at.
std::optional<UdpAddress> part_from_dds(const sft_control_UdpLocator& in) {
  IpAddress ip;
  std::ranges::copy(in.address, ip.bytes.begin());
  const bool sound = in.family == (ip.is_ipv4() ? 4 : 6) && !ip.is_any() && !ip.is_multicast();
  if (!sound || in.port == 0) return std::nullopt;
  return UdpAddress{ip, in.port, in.receive_buffer_bytes, in.wireless};
}

sft_control_Qos to_dds(const Qos& qos) {
  sft_control_Qos out{};
  out.reliability = static_cast<std::uint8_t>(qos.reliability);
  out.durability = static_cast<std::uint8_t>(qos.durability);
  out.liveliness = static_cast<std::uint8_t>(qos.liveliness);
  out.deadline = static_cast<std::uint64_t>(qos.deadline.count());
  out.liveliness_lease = static_cast<std::uint64_t>(qos.liveliness_lease.count());
  out.lifespan = static_cast<std::uint64_t>(qos.lifespan.count());
  out.history_depth = qos.history_depth;
  return out;
}

std::optional<Qos> part_from_dds(const sft_control_Qos& in) {
  constexpr std::uint64_t longest = INT64_MAX;
  if (in.reliability > 1 || in.durability > 1 || in.liveliness > 1 || in.deadline > longest ||
      in.liveliness_lease > longest || in.lifespan > longest) {
    return std::nullopt;
  }
  return Qos{.reliability = static_cast<Reliability>(in.reliability),
             .durability = static_cast<Durability>(in.durability),
             .deadline = std::chrono::nanoseconds(in.deadline),
             .liveliness = static_cast<Liveliness>(in.liveliness),
             .liveliness_lease = std::chrono::nanoseconds(in.liveliness_lease),
             .lifespan = std::chrono::nanoseconds(in.lifespan),
             .history_depth = in.history_depth};
}

sft_control_Account to_dds(const Account& account) {
  sft_control_Account out{};
  out.writer = account.id.pair.writer;
  out.reader = account.id.pair.reader;
  out.said_by = static_cast<std::uint8_t>(account.id.said_by);
  out.sent = account.by_writer.sent;
  out.withheld = account.by_writer.withheld;
  out.dropped = account.by_writer.dropped;
  out.retained = account.by_writer.retained;
  out.bytes_sent = account.by_writer.bytes_sent;
  out.bytes_saved = account.by_writer.bytes_saved;
  out.received = account.by_reader.received;
  out.lost = account.by_reader.lost;
  return out;
}

/// Empty where neither side says it. What one side says of the other's counts is left out.
std::optional<Account> part_from_dds(const sft_control_Account& in) {
  if (in.said_by > static_cast<std::uint8_t>(Role::reader)) return std::nullopt;
  Account account{.id = {{in.writer, in.reader}, static_cast<Role>(in.said_by)}};
  if (account.id.said_by == Role::writer) {
    account.by_writer = {.sent = in.sent,
                         .withheld = in.withheld,
                         .dropped = in.dropped,
                         .retained = in.retained,
                         .bytes_sent = in.bytes_sent,
                         .bytes_saved = in.bytes_saved};
  } else {
    account.by_reader = {.received = in.received, .lost = in.lost};
  }
  return account;
}

Result<void> check_lengths(const sft_control_SignNews& in) {
  const auto check = [](const char* what, std::size_t count, std::size_t most) -> Result<void> {
    if (count <= most) return {};
    return fail(Errc::malformed, "a sign of life with " + std::to_string(count) + " " + what + ", of which " +
                                     std::to_string(most) + " are the most");
  };
  Result<void> checked = check("writers", in.writers._length, assertions_max);
  if (checked) checked = check("writers' progress", in.progress._length, progress_max);
  if (checked) checked = check("endpoints that are asked about", in.asked_about._length, asked_about_max);
  if (checked) checked = check("accounts", in.accounts._length, accounts_max);
  return checked;
}

bool has_news(const Assertion& sign) { return sign.wants_signs || sign.tells_more_than_life(); }

sft_control_SignNews news_of(const Assertion& sign, ControlStorage& storage) {
  sft_control_SignNews out{};
  out.wants_signs = sign.wants_signs;
  out.writers = borrow(sign.writers, assertions_max);
  for (const Progress& p : sign.progress) {
    if (storage.progress.size() < progress_max) storage.progress.push_back({p.writer, p.samples, p.bytes});
  }
  const auto progress = static_cast<std::uint32_t>(storage.progress.size());
  out.progress = {progress, progress, storage.progress.data(), false};
  out.asked_about = borrow(sign.asked_about, asked_about_max);
  for (const Account& account : sign.accounts) {
    if (storage.accounts.size() < accounts_max) storage.accounts.push_back(to_dds(account));
  }
  const auto accounts = static_cast<std::uint32_t>(storage.accounts.size());
  out.accounts = {accounts, accounts, storage.accounts.data(), false};
  return out;
}

Result<void> take_news(const sft_control_SignNews& in, Assertion& sign) {
  if (Result<void> sound = check_lengths(in); !sound) return sound;
  sign.wants_signs = in.wants_signs;
  sign.writers = copy(in.writers);
  for (std::uint32_t i = 0; i < in.progress._length; ++i) {
    const sft_control_Progress& p = in.progress._buffer[i];
    sign.progress.push_back({p.writer, p.samples, p.bytes});
  }
  sign.asked_about = copy(in.asked_about);
  for (std::uint32_t i = 0; i < in.accounts._length; ++i) {
    const std::optional<Account> account = part_from_dds(in.accounts._buffer[i]);
    if (!account) return fail(Errc::malformed, "a sign of life with an account of neither writer nor reader");
    sign.accounts.push_back(*account);
  }
  return {};
}

}  // namespace

sft_control_Request to_dds(const Request& request, ControlStorage& storage) {
  sft_control_Request out{};
  out.reader = request.reader;
  out.version = sft_control_protocol_version;
  out.request_sequence = request.sequence;
  out.mask = borrow(request.mask_words, mask_words_max);
  storage.wants = wants_of(request);
  out.wants = borrow(storage.wants, wants_bytes_max);
  out.listening = borrow(request.listening, writers_per_reader_max);
  out.attached = borrow(request.attached, writers_per_reader_max);
  out.begun = borrow(request.begun, writers_per_reader_max);
  return out;
}

sft_control_Endpoint to_dds(const Endpoint& endpoint, ControlStorage& storage) {
  sft_control_Endpoint out{};
  out.id = endpoint.id;
  out.version = sft_control_protocol_version;
  out.role = static_cast<std::uint8_t>(endpoint.role);
  out.node_id = endpoint.node_id;
  out.life_lease_ms = static_cast<std::uint32_t>(endpoint.life_lease.count());
  put(out.node, endpoint.node);
  put(out.topic, endpoint.topic);
  put(out.given_topic, endpoint.given_topic);
  put(out.type_name, endpoint.type_name);
  out.type_hash = endpoint.type_hash;
  out.type_description = borrow(endpoint.type_description, type_description_bytes_max);
  std::copy(endpoint.host.bytes.begin(), endpoint.host.bytes.end(), out.host);
  put(out.memory_failure, endpoint.memory_failure);
  out.network = endpoint.network;
  out.may_use_shm = endpoint.may_use_memory;
  out.may_use_udp = endpoint.may_use_network;
  for (const UdpAddress& a : endpoint.addresses) {
    if (storage.addresses.size() < addresses_max) storage.addresses.push_back(to_dds(a));
  }
  const auto addresses = static_cast<std::uint32_t>(storage.addresses.size());
  out.addresses = {addresses, addresses, storage.addresses.data(), false};
  out.doorbell_page = endpoint.doorbell.page;
  out.doorbell_slot = endpoint.doorbell.slot;
  out.max_sample_bytes = endpoint.max_sample_bytes;
  out.waits = endpoint.waits;
  out.qos = to_dds(endpoint.qos);
  out.request = to_dds(endpoint.request, storage);
  out.revision = endpoint.revision;
  return out;
}

sft_control_ReaderWord in_word(sft_control_Endpoint& announcement) {
  sft_control_ReaderWord word{};
  word.instance = announcement.instance;
  word.part = static_cast<std::uint8_t>(ReaderPart::announcement);
  word.announcement = {1, 1, &announcement, false};
  return word;
}

sft_control_ReaderWord in_word(sft_control_Request& request, std::uint64_t key) {
  sft_control_ReaderWord word{};
  word.instance = key;
  word.part = static_cast<std::uint8_t>(ReaderPart::request);
  word.request = {1, 1, &request, false};
  return word;
}

sft_control_Assertion to_dds(const Assertion& assertion, ControlStorage& storage) {
  sft_control_Assertion out{};
  out.node = assertion.node;
  out.version = sft_control_protocol_version;
  put_digest(out.digest_of_writers, assertion.digest_of_writers);
  put_digest(out.digest_of_readers, assertion.digest_of_readers);
  if (!has_news(assertion)) return out;
  out.news._d = true;
  out.news._u.news = news_of(assertion, storage);
  return out;
}

Result<Assertion> from_dds(const sft_control_Assertion& in) {
  if (in.version != sft_control_protocol_version) return wrong_version(in.version);
  if (in.node == 0) return fail(Errc::malformed, "an assertion of no node");
  Assertion out{.node = in.node,
                .writers = {},
                .digest_of_writers = digest_in(in.digest_of_writers),
                .digest_of_readers = digest_in(in.digest_of_readers)};
  if (!in.news._d) return out;
  if (const Result<void> sound = take_news(in.news._u.news, out); !sound)
    return tl::unexpected(sound.error());
  return out;
}

static Result<Request> requested(const sft_control_Request& in, EndpointId reader) {
  Request out{.reader = reader,
              .sequence = in.request_sequence,
              .mask_words = copy(in.mask),
              .listening = copy(in.listening),
              .attached = copy(in.attached),
              .begun = copy(in.begun)};
  const auto* const wants = reinterpret_cast<const std::byte*>(in.wants._buffer);
  if (!take_wants({wants, in.wants._length}, out))
    return fail(Errc::malformed, "a request for something that this release does not know");
  return out;
}

Result<Request> from_dds(const sft_control_Request& request) {
  if (request.version != sft_control_protocol_version) return wrong_version(request.version);
  if (request.reader == 0) return fail(Errc::malformed, "a request of no reader");
  if (request.request_sequence > request_sequence_max) return beyond_all(request.request_sequence);
  return requested(request, request.reader);
}

Result<Endpoint> from_dds(const sft_control_Endpoint& in) {
  if (in.version != sft_control_protocol_version) return wrong_version(in.version);
  if (in.id == 0 || in.role > static_cast<std::uint8_t>(Role::reader)) {
    return fail(Errc::malformed, "an endpoint without id or role");
  }
  if (const Result<void> named = check_names(in); !named) return tl::unexpected(named.error());
  if (in.request.request_sequence > request_sequence_max) return beyond_all(in.request.request_sequence);
  const std::optional<Qos> qos = part_from_dds(in.qos);
  if (!qos) return fail(Errc::malformed, "an endpoint of unknown quality of service");
  Endpoint out;
  out.id = in.id;
  out.role = static_cast<Role>(in.role);
  out.node_id = in.node_id;
  out.life_lease = std::chrono::milliseconds(in.life_lease_ms);
  out.node = in.node;
  out.topic = without_slash(in.topic);
  out.given_topic = in.given_topic;
  out.type_name = in.type_name;
  out.type_hash = in.type_hash;
  out.type_description = copy(in.type_description);
  std::copy(std::begin(in.host), std::end(in.host), out.host.bytes.begin());
  // People read it. A text that was cut within a letter, or is none, is no reason to refuse the endpoint.
  if (fault_of_name(in.memory_failure).empty()) out.memory_failure = in.memory_failure;
  out.network = in.network;
  out.may_use_memory = in.may_use_shm;
  out.may_use_network = in.may_use_udp;
  for (std::uint32_t i = 0; i < in.addresses._length; ++i) {
    if (const auto address = part_from_dds(in.addresses._buffer[i])) out.addresses.push_back(*address);
  }
  out.doorbell = {in.doorbell_page, in.doorbell_slot};
  out.max_sample_bytes = in.max_sample_bytes;
  out.waits = in.waits;
  out.qos = *qos;
  Result<Request> request = requested(in.request, in.id);
  if (!request) return tl::unexpected(request.error());
  out.request = std::move(*request);
  out.revision = in.revision;
  return out;
}

Result<std::variant<Endpoint, Request>> from_dds(const sft_control_ReaderWord& word) {
  using Either = std::variant<Endpoint, Request>;
  const std::uint32_t announcements = word.announcement._length;
  const std::uint32_t requests = word.request._length;
  const bool announces = word.part == static_cast<std::uint8_t>(ReaderPart::announcement) &&
                         announcements == 1 && requests == 0 &&
                         word.announcement._buffer[0].instance == word.instance;
  const bool asks =
      word.part == static_cast<std::uint8_t>(ReaderPart::request) && announcements == 0 && requests == 1;
  if (announces)
    return from_dds(word.announcement._buffer[0]).map([](Endpoint&& e) { return Either(std::move(e)); });
  if (asks) return from_dds(word.request._buffer[0]).map([](Request&& r) { return Either(std::move(r)); });
  return fail(Errc::malformed, "neither one announcement under its key nor one request");
}

std::uint32_t control_protocol_version() { return sft_control_protocol_version; }

}  // namespace sft::core
