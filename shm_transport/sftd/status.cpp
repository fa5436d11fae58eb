#include "shm_transport/sftd/status.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <ctime>
#include <iterator>
#include <nlohmann/json.hpp>

#include "shm_transport/sftd/pools.h"

namespace sft::shm {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(Versions, sftd, iceoryx, protocol)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(PoolUse, bytes, chunks, in_use, peak)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(UserUse, pid, name, publishers, subscribers)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(Holding, chunks, peak, bytes)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(PublisherUse, user, publisher, subscribers, held)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(SubscriberUse, user, publisher, waiting, held)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(Usage, pools, users, publishers, subscribers, leaks_healed,
                                                locks_healed, deaths, unaudited, stamp_ns)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(Status, pid, versions, since_ns, idle_exit_s, writers,
                                                readers, sample_bytes, management_bytes, usage)

namespace {

using Lines = std::back_insert_iterator<std::string>;

std::string idle_exit_of(const Status& status) {
  return status.idle_exit_s == 0 ? "never" : fmt::format("after {} s", status.idle_exit_s);
}

void write_head(Lines out, const Status& status, std::int64_t now_ns) {
  constexpr std::int64_t ns_per_s = 1'000'000'000;
  const std::time_t since = status.since_ns / ns_per_s;
  // The clock may have been set back since the daemon began.
  const std::chrono::seconds up(std::max<std::int64_t>(now_ns - status.since_ns, 0) / ns_per_s);
  fmt::format_to(out, "sftd {} (pid {}), iceoryx {}, protocol {}\n", status.versions.sftd, status.pid,
                 status.versions.iceoryx, status.versions.protocol);
  fmt::format_to(out, "since {:%F %T} ({:%T}), idle exit {}\n", fmt::localtime(since), up,
                 idle_exit_of(status));
  fmt::format_to(out, "memory {} for samples, {} to manage them; group {} publishes{}\n",
                 format_bytes(status.sample_bytes), format_bytes(status.management_bytes), status.writers,
                 status.readers.empty() ? " and subscribes" : ", " + status.readers + " only subscribes");
  const Usage& usage = status.usage;
  fmt::format_to(out,
                 "freed {} lost chunks, opened {} locks; {} programs died, {} of them since the last search "
                 "for lost chunks\n",
                 usage.leaks_healed, usage.locks_healed, usage.deaths, usage.unaudited);
}

void write_pools(Lines out, const std::vector<PoolUse>& pools) {
  fmt::format_to(out, "\n{:>12} {:>8} {:>8} {:>8}\n", "CHUNK SIZE", "COUNT", "IN USE", "PEAK");
  for (const PoolUse& pool : pools)
    fmt::format_to(out, "{:>12} {:>8} {:>8} {:>8}\n", format_bytes(pool.bytes), pool.chunks, pool.in_use,
                   pool.peak);
}

void write_users(Lines out, const std::vector<UserUse>& users) {
  fmt::format_to(out, "\n{:<44} {:>8} {:>11} {:>12}\n", "PROGRAM", "PID", "PUBLISHERS", "SUBSCRIBERS");
  for (const UserUse& user : users)
    fmt::format_to(out, "{:<44} {:>8} {:>11} {:>12}\n", user.name, user.pid, user.publishers,
                   user.subscribers);
}

void write_publishers(Lines out, const std::vector<PublisherUse>& publishers) {
  if (publishers.empty()) return;
  fmt::format_to(out, "\n{:<16} {:<44} {:>6} {:>6} {:>10} {:>12}\n", "PUBLISHER", "PROGRAM", "CHUNKS", "PEAK",
                 "MEMORY", "SUBSCRIBERS");
  for (const PublisherUse& use : publishers)
    fmt::format_to(out, "{:<16} {:<44} {:>6} {:>6} {:>10} {:>12}\n", use.publisher, use.user, use.held.chunks,
                   use.held.peak, format_bytes(use.held.bytes), use.subscribers);
}

void write_subscribers(Lines out, const std::vector<SubscriberUse>& subscribers) {
  if (subscribers.empty()) return;
  fmt::format_to(out, "\n{:<16} {:<44} {:>6} {:>6} {:>10} {:>12}\n", "SUBSCRIBER TO", "PROGRAM", "CHUNKS",
                 "PEAK", "MEMORY", "WAITING");
  for (const SubscriberUse& use : subscribers)
    fmt::format_to(out, "{:<16} {:<44} {:>6} {:>6} {:>10} {:>12}\n", use.publisher, use.user, use.held.chunks,
                   use.held.peak, format_bytes(use.held.bytes), use.waiting);
}

}  // namespace

/// Names come from other programs, so bytes that are not UTF-8 are replaced.
std::string to_json(const Status& status) {
  return nlohmann::json(status).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::optional<Status> parse_status(std::string_view json) {
  try {
    return nlohmann::json::parse(json).get<Status>();
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

std::string to_table(const Status& status, std::int64_t now_ns) {
  std::string text;
  const auto out = std::back_inserter(text);
  write_head(out, status, now_ns);
  write_pools(out, status.usage.pools);
  write_users(out, status.usage.users);
  write_publishers(out, status.usage.publishers);
  write_subscribers(out, status.usage.subscribers);
  return text;
}

}  // namespace sft::shm
