#include "tools/sft/account_text.h"

#include <fmt/format.h>

#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

constexpr const char* not_reported = "not reported yet";
constexpr const char* account_row = "  {:<27.27} {:<3.3} {:>9.9} {:>18.18} {:>9.9} {:>7.7}";
constexpr std::size_t sent_width = 9, withheld_width = 9, lost_width = 7;

double whole_bytes(const DomainSnapshot::Sent& account) {
  return static_cast<double>(account.bytes_sent) + static_cast<double>(account.bytes_saved);
}

std::string saved_percent(const DomainSnapshot::Sent& account, int decimals) {
  return percent_text(static_cast<double>(account.bytes_saved), whole_bytes(account), decimals);
}

}  // namespace

bool is_reported(const DomainSnapshot::Pair& pair) {
  return !pair.matched ||
         ((pair.dds_publisher || pair.account.publisher) && (pair.dds_subscriber || pair.account.subscriber));
}

std::string unanswered_text(const DomainSnapshot::Pair& pair) {
  if (is_reported(pair)) return {};
  const bool publisher = !pair.dds_publisher && !pair.account.publisher;
  const bool subscriber = !pair.dds_subscriber && !pair.account.subscriber;
  const char* const who = publisher && subscriber ? "both nodes are heard, and neither answers"
                          : publisher             ? "the publisher's node is heard, and does not answer"
                                                  : "the subscriber's node is heard, and does not answer";
  return fmt::format(
      "{}: what this host sends may not arrive there (because of a firewall, or of a network "
      "that works in one direction only), or the node is busy: then --wait helps",
      who);
}

/// Returns true if the subscriber has taken none of the samples sent. A subscriber detects a loss only when
/// a later sample arrives. So if no sample arrives, the subscriber reports no losses, and this case has to
/// be detected separately.
bool takes_none(const DomainSnapshot::Pair& pair) {
  const auto& [publisher, subscriber] = pair.account;
  return pair.matched && publisher && subscriber && publisher->sent > 0 && subscriber->received == 0;
}

std::string takes_none_text(const DomainSnapshot::Pair& pair) {
  if (!takes_none(pair)) return {};
  const std::uint64_t sent = pair.account.publisher->sent;
  const bool by_memory = pair.connected && pair.transport == TransportKind::shm;
  return fmt::format("{} {} sent, and the subscriber has taken none: its program does not take them{}",
                     count_text(sent, "sample"), sent == 1 ? "was" : "were",
                     by_memory
                         ? ""
                         : ", or they do not arrive (because of a firewall, or because a path drops long "
                           "datagrams, which the log of the publisher's node names)");
}

std::string unreadable_text(const DomainSnapshot::Pair& pair) {
  const auto& subscriber = pair.account.subscriber;
  if (!pair.dds_publisher || !subscriber || subscriber->received > 0 || subscriber->lost == 0) return {};
  return "samples came, and none was taken: the subscriber's program does not take them, or they cannot be "
         "read: their numbers are big-endian, they are not XCDR1, or they do not fit the type (the log of "
         "the "
         "subscriber's node says which)";
}

std::string sent_text(const DomainSnapshot::Pair& pair) {
  if (!pair.account.publisher) return not_reported;
  const DomainSnapshot::Sent& account = *pair.account.publisher;
  std::string text = count_text(account.sent, "sample");
  text += whole_bytes(account) == 0
              ? ", nothing over the network"
              : fmt::format(", {} over the network", bytes_text(static_cast<double>(account.bytes_sent)));
  if (account.retained > 0)
    text += fmt::format("; {} before", count_text(account.retained, "retained sample"));
  return text;
}

std::string saved_text(const DomainSnapshot::Pair& pair) {
  if (!pair.account.publisher) return not_reported;
  const DomainSnapshot::Sent& account = *pair.account.publisher;
  if (whole_bytes(account) == 0) return "0 B";
  return fmt::format("{}, {} of the whole samples", bytes_text(static_cast<double>(account.bytes_saved)),
                     saved_percent(account, 4));
}

std::string withheld_text(const DomainSnapshot::Pair& pair) {
  if (!pair.account.publisher) return not_reported;
  return fmt::format("{}; {} dropped", count_text(pair.account.publisher->withheld, "sample"),
                     pair.account.publisher->dropped);
}

std::string diverted_text(const DomainSnapshot::Pair& pair) {
  if (!pair.account.publisher || pair.account.publisher->diverted == 0) return "";
  const DomainSnapshot::Sent& account = *pair.account.publisher;
  const std::string why =
      account.too_large_bytes == 0
          ? "shared memory had no chunk free"
          : fmt::format("the largest chunk of shared memory has room for {}, and samples have up to {}",
                        bytes_text(static_cast<double>(account.chunk_bytes)),
                        bytes_text(static_cast<double>(account.too_large_bytes)));
  return fmt::format(
      "{} of these went by UDP: {}: enlarge /dev/shm, or set total_mib or [[pool]] in sftd.toml",
      account.diverted, why);
}

std::string lost_text(const DomainSnapshot::Pair& pair) {
  if (!pair.account.subscriber) return not_reported;
  return fmt::format("{}; {} received", count_text(pair.account.subscriber->lost, "sample"),
                     pair.account.subscriber->received);
}

std::string account_headings() {
  return fmt::format(account_row, "PAIR", "BY", "SENT", "SAVED", "WITHHELD", "LOST");
}

std::string account_columns(const std::string& names, const std::string& by,
                            const DomainSnapshot::Pair& pair) {
  std::string sent = "-", saved = "-", withheld = "-", lost = "-";
  if (const auto& account = pair.account.publisher) {
    sent = short_count_text(account->sent, sent_width);
    saved = bytes_text(static_cast<double>(account->bytes_saved));
    if (whole_bytes(*account) > 0) saved += " " + saved_percent(*account, 2);
    withheld = short_count_text(account->withheld, withheld_width);
  }
  if (const auto& account = pair.account.subscriber) lost = short_count_text(account->lost, lost_width);
  return fmt::format(account_row, names, by, sent, saved, withheld, lost);
}

}  // namespace sft::tool
