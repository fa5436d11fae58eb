#include "tools/sft/chunk_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "sft/options.h"
#include "tools/sft/describe.h"
#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

constexpr const char* status_of_daemon = "/dev/shm/sft_status";  // the file that `sftd status` prints
constexpr std::size_t topics_named = 3;

struct Pool {
  std::uint64_t bytes = 0;  ///< the size of the largest sample in a chunk
  std::uint64_t chunks = 0;
  std::uint64_t peak = 0;  ///< the maximum number of chunks that were in use at a time
};

std::string size_text(std::uint64_t bytes) { return bytes_text(static_cast<double>(bytes)); }

/// Returns the pools, sorted by size. The result is empty if no daemon has written a status.
std::vector<Pool> pools_of_daemon() {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(std::filesystem::symlink_status(status_of_daemon, ignored)))
    return {};
  std::vector<Pool> pools;
  try {
    std::ifstream file(status_of_daemon);
    const auto status = nlohmann::json::parse(file);
    for (const auto& pool : status.at("usage").at("pools"))
      pools.push_back({pool.at("bytes"), pool.at("chunks"), pool.at("peak")});
  } catch (const nlohmann::json::exception&) {
    return {};
  }
  std::ranges::sort(pools, {}, &Pool::bytes);
  return pools;
}

/// Returns the topics of publishers that may use shared memory on this host and have announced a maximum size
/// above `bytes`. Publishers that announce the default size are left out, since the default does not depend
/// on their samples.
std::set<std::string> topics_of_larger_samples(const DomainSnapshot& domain, std::uint64_t bytes) {
  std::set<std::string> topics;
  for (const DomainSnapshot::Endpoint& publisher : domain.publishers) {
    if (publisher.same_machine && publisher.may_use_shm && publisher.max_sample_bytes > bytes &&
        publisher.max_sample_bytes != PublisherOptions{}.max_sample_bytes)
      topics.insert(publisher.topic);
  }
  return topics;
}

/// Returns the topics of publishers of this host that have reported samples too large for shared memory,
/// each with the largest size, as "images (6.3 MB)".
std::set<std::string> topics_that_were_diverted(const DomainSnapshot& domain) {
  std::map<std::string, std::uint64_t> largest;
  for (const DomainSnapshot::Pair& pair : domain.pairs) {
    const auto* const publisher = endpoint_of(pair.publisher, domain.publishers);
    if (publisher == nullptr || !publisher->same_machine || !pair.account.publisher) continue;
    std::uint64_t& bytes = largest[publisher->topic];
    bytes = std::max(bytes, pair.account.publisher->too_large_bytes);
  }
  std::set<std::string> topics;
  for (const auto& [topic, bytes] : largest)
    if (bytes > 0) topics.insert(fmt::format("{} ({})", topic, size_text(bytes)));
  return topics;
}

std::string list_of(const std::set<std::string>& topics) {
  std::string text;
  std::size_t named = 0;
  for (const std::string& topic : topics) {
    if (named++ == topics_named) return text + fmt::format(" and {} more", topics.size() - topics_named);
    text += (text.empty() ? "" : ", ") + topic;
  }
  return text;
}

}  // namespace

Finding check_chunks(const DomainSnapshot& domain) {
  const std::vector<Pool> pools = pools_of_daemon();
  if (pools.empty()) return {"chunks", Health::ok, "no sftd has set any memory aside for samples"};
  const std::uint64_t largest = pools.back().bytes;
  std::string text = fmt::format("the largest ones are for samples of {}", size_text(largest));
  const std::set<std::string> topics = topics_of_larger_samples(domain, largest);
  if (!topics.empty())
    text += fmt::format("; publishers of this host announce larger ones: {}", list_of(topics));
  const std::set<std::string> diverted = topics_that_were_diverted(domain);
  if (!diverted.empty()) text += fmt::format("; larger samples went by UDP: {}", list_of(diverted));
  std::string used_up;
  for (const Pool& pool : pools) {
    if (pool.chunks > 0 && pool.peak >= pool.chunks)
      used_up += fmt::format("{}{} x {}", used_up.empty() ? "" : ", ", pool.chunks, size_text(pool.bytes));
  }
  if (!used_up.empty()) text += "; all of a size have been in use at a time: " + used_up;
  if (topics.empty() && diverted.empty() && used_up.empty()) return {"chunks", Health::ok, text};
  return {"chunks", Health::warning, text,
          "Samples without a chunk go by UDP: enlarge /dev/shm, or set total_mib or [[pool]] in sftd.toml "
          "(docs/operations.md has a table)."};
}

}  // namespace sft::tool
