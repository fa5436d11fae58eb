#include "shm_transport/sftd/config.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <string_view>

#include "core/platform/text_file.h"

namespace sft::shm {

namespace {

constexpr std::int64_t largest_mib = 1 << 20;
constexpr std::int64_t largest_pool_kib = 1 << 20;  // iceoryx was tested up to this size
constexpr std::int64_t most_chunks = 1 << 20;
constexpr std::int64_t longest_idle_s = 1 << 30;
constexpr std::size_t most_pools = 32;

/// The first error in the configuration file. Later errors are ignored.
class FirstError {
 public:
  explicit FirstError(std::string file) : file_(std::move(file)) {}

  void add(const toml::source_region& where, std::string_view key, const std::string& text) {
    if (text_.empty())
      text_ = fmt::format("{}:{}: {}{}{}", file_, where.begin.line, key, key.empty() ? "" : ": ", text);
  }
  const std::string& text() const { return text_; }

 private:
  std::string file_;
  std::string text_;
};

/// A table of the configuration file. The keys that a caller reads are known; refuse_the_rest() refuses all
/// other keys of the table.
class Section {
 public:
  Section(const toml::table& table, std::string name, FirstError& first_error)
      : table_(table), name_(std::move(name)), error_(first_error) {}

  template <class Number>
  void read(std::string_view key, std::int64_t least, std::int64_t most, Number& value) {
    const toml::node* node = find(key);
    if (node == nullptr) return;
    const auto number = node->is_integer() ? node->value<std::int64_t>() : std::nullopt;
    if (number && *number >= least && *number <= most) {
      value = static_cast<Number>(*number);
    } else {
      refuse(
          *node, key,
          fmt::format("not a whole number from {0} to {1}: write for example {2} = {0}", least, most, key));
    }
  }

  void read(std::string_view key, std::string& value) {
    const toml::node* node = find(key);
    if (node == nullptr) return;
    value = node->is_string() ? node->value_or(std::string()) : std::string();
    if (value.empty()) refuse(*node, key, fmt::format("not a name: write {} = \"name\"", key));
  }

  const toml::node* find(std::string_view key) {
    known_.push_back(key);
    return table_.get(key);
  }

  void refuse(const toml::node& node, std::string_view key, const std::string& text) {
    error_.add(node.source(), name_.empty() ? std::string(key) : name_ + "." + std::string(key), text);
  }

  void refuse_the_rest() {
    for (const auto& [key, node] : table_) {
      if (std::ranges::find(known_, key.str()) != known_.end()) continue;
      refuse(node, key.str(),
             fmt::format("unknown key: use one of {}, or remove it", fmt::join(known_, ", ")));
    }
  }

  const toml::table& table() const { return table_; }

 private:
  const toml::table& table_;
  const std::string name_;
  FirstError& error_;
  std::vector<std::string_view> known_;
};

/// Calls `read` with the section of this name, if the file has one.
template <class Read>
void within(Section& file, std::string_view name, FirstError& first_error, Read read) {
  const toml::node* node = file.find(name);
  if (node == nullptr) return;
  if (!node->is_table()) return file.refuse(*node, name, fmt::format("not a section: write [{}]", name));
  Section section(*node->as_table(), std::string(name), first_error);
  read(section);
  section.refuse_the_rest();
}

Pool read_pool(const toml::table& table, FirstError& first_error) {
  Section section(table, "pool", first_error);
  std::size_t size_kib = 0;
  Pool pool;
  section.read("size_kib", 1, largest_pool_kib, size_kib);
  section.read("count", 2, most_chunks, pool.count);
  section.refuse_the_rest();
  if (!table.contains("size_kib") || !table.contains("count"))
    section.refuse(table, "size_kib, count", "one of them is missing: give both");
  pool.bytes = size_kib << 10;
  return pool;
}

void read_pools(Section& file, FirstError& first_error, DaemonSettings& settings) {
  const toml::node* node = file.find("pool");
  if (node == nullptr) return;
  if (!node->is_array_of_tables()) return file.refuse(*node, "pool", "not a list of sizes: write [[pool]]");
  if (settings.pool_bytes)
    return file.refuse(*node, "pool", "the file has total_mib as well: remove one of the two");
  for (const toml::node& entry : *node->as_array())
    settings.pools.push_back(read_pool(*entry.as_table(), first_error));
  if (settings.pools.size() > most_pools)
    file.refuse(*node, "pool", fmt::format("there are more than {} pools: remove some", most_pools));
  std::ranges::sort(settings.pools, {}, &Pool::bytes);
  if (std::ranges::adjacent_find(settings.pools, {}, &Pool::bytes) != settings.pools.end())
    file.refuse(*node, "pool", "two pools have the same size_kib: join them");
}

void read_budget(Section& file, DaemonSettings& settings) {
  std::size_t mib = 0;
  file.read("total_mib", static_cast<std::int64_t>(smallest_budget_bytes >> 20), largest_mib, mib);
  if (mib != 0) settings.pool_bytes = mib << 20;
}

void read_idle_exit(Section& file, DaemonSettings& settings) {
  std::int64_t seconds = 0;
  file.read("idle_exit_s", 0, longest_idle_s, seconds);
  settings.idle_exit = std::chrono::seconds(seconds);
}

void read_log_level(Section& file, std::optional<LogLevel>& level) {
  const toml::node* node = file.find("log_level");
  if (node == nullptr) return;
  level = log_level_of(node->value_or(std::string()));
  if (!level) file.refuse(*node, "log_level", "not a level: write error, warning, info or debug");
}

void read_limits(Section& section, Limits& limits) {
  const Limits most;
  section.read("processes", 1, most.processes, limits.processes);
  section.read("publishers_per_process", 1, most.publishers_per_process, limits.publishers_per_process);
  section.read("subscribers_per_process", 1, most.subscribers_per_process, limits.subscribers_per_process);
}

void read_access(Section& section, AccessSettings& access) {
  section.read("writers", access.writers);
  section.read("readers", access.readers);
  if (access.writers.empty())
    section.refuse(section.table(), "writers", "missing: name the group that may publish");
}

Config read_file(const toml::table& table, FirstError& first_error) {
  Config config;
  Section file(table, "", first_error);
  read_budget(file, config.settings);
  read_pools(file, first_error, config.settings);
  read_idle_exit(file, config.settings);
  read_log_level(file, config.log_level);
  within(file, "limits", first_error,
         [&](Section& section) { read_limits(section, config.settings.limits); });
  within(file, "access", first_error,
         [&](Section& section) { read_access(section, config.settings.access); });
  file.refuse_the_rest();
  return config;
}

}  // namespace

Result<Config> read_config(const std::string& file) {
  const Result<std::string> text = core::read_text_file(file);
  if (!text) return tl::unexpected(text.error());
  FirstError first_error(file);
  try {
    const Config config = read_file(toml::parse(*text, file), first_error);
    if (first_error.text().empty()) return config;
  } catch (const toml::parse_error& error) {
    first_error.add(error.source(), "",
                    std::string(error.description()) + ": correct it, see https://toml.io");
  }
  return fail(Errc::invalid_argument, first_error.text());
}

}  // namespace sft::shm
