#include "core/control/control_codec.h"

#include <algorithm>
#include <optional>

namespace sft::core {

namespace {

dds_sequence_unsigned_long_long borrow(const std::vector<std::uint64_t>& values, std::size_t most) {
  const auto n = static_cast<std::uint32_t>(std::min(values.size(), most));
  return {n, n, const_cast<std::uint64_t*>(values.data()), false};
}

std::vector<std::uint64_t> copy(const dds_sequence_unsigned_long_long& s) {
  return {s._buffer, s._buffer + s._length};
}

tl::unexpected<Error> wrong_version(unsigned version) {
  return fail(Errc::malformed, "a control sample of protocol version " + std::to_string(version) +
                                   ", this is " + std::to_string(sft_control_protocol_version));
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

bool has_news(const Assertion& sign) { return sign.tells_anything(); }

sft_control_SignNews news_of(const Assertion& sign, ControlStorage& storage) {
  sft_control_SignNews out{};
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

sft_control_Assertion to_dds(const Assertion& assertion, ControlStorage& storage) {
  sft_control_Assertion out{};
  out.node = assertion.node;
  out.version = sft_control_protocol_version;
  if (!has_news(assertion)) return out;
  out.news._d = true;
  out.news._u.news = news_of(assertion, storage);
  return out;
}

Result<Assertion> from_dds(const sft_control_Assertion& in) {
  if (in.version != sft_control_protocol_version) return wrong_version(in.version);
  if (in.node == 0) return fail(Errc::malformed, "an assertion of no node");
  Assertion out{.node = in.node, .writers = {}};
  if (!in.news._d) return out;
  if (const Result<void> sound = take_news(in.news._u.news, out); !sound)
    return tl::unexpected(sound.error());
  return out;
}

std::uint32_t control_protocol_version() { return sft_control_protocol_version; }

}  // namespace sft::core
