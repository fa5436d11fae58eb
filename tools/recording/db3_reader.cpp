#include "tools/recording/db3_reader.h"

#include <sqlite3.h>

#include <filesystem>
#include <system_error>
#include <utility>

namespace sft::recording {

namespace {

/// Returns the name of the file as a URI. While rosbag2 writes, its latest data are in a second file with
/// the ending "-wal". If there is no such file, the URI promises SQLite that nothing changes, because
/// SQLite would otherwise create files itself.
std::string uri_of(const std::string& path) {
  std::string uri = "file:";
  for (const char c : path) {
    constexpr const char* digits = "0123456789ABCDEF";
    const auto code = static_cast<unsigned char>(c);
    const bool is_plain = c != '?' && c != '#' && c != '%' && code > ' ' && code < 0x7f;
    uri += is_plain ? std::string(1, c) : std::string{'%', digits[code >> 4], digits[code & 15]};
  }
  std::error_code error;
  const auto log_bytes = std::filesystem::file_size(path + "-wal", error);
  return uri + (error || log_bytes == 0 ? "?immutable=1" : "");
}

std::string text_at(sqlite3_stmt* row, int column) {
  const auto* const text = reinterpret_cast<const char*>(sqlite3_column_text(row, column));
  return text == nullptr ? ""
                         : std::string(text, static_cast<std::size_t>(sqlite3_column_bytes(row, column)));
}

}  // namespace

void Db3Reader::Close::operator()(sqlite3* database) const { sqlite3_close_v2(database); }
void Db3Reader::Close::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Db3Reader::Db3Reader(sqlite3* database) : database_(database) {
  // The number of steps of SQLite between two calls of stop(). They take some milliseconds.
  constexpr int steps = 100'000;
  const auto stop = [](void* self) { return static_cast<Db3Reader*>(self)->is_stopped() ? 1 : 0; };
  sqlite3_progress_handler(database, steps, stop, this);
}

Result<std::unique_ptr<Db3Reader>> Db3Reader::open(const std::string& path) {
  sqlite3* opened = nullptr;
  const int code =
      sqlite3_open_v2(uri_of(path).c_str(), &opened, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
  std::unique_ptr<Db3Reader> reader(new Db3Reader(opened));
  if (code != SQLITE_OK) return fail(Errc::system, "'" + path + "' cannot be read: " + sqlite3_errstr(code));
  sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  if (!reader->has_table("topics") || !reader->has_table("messages")) {
    const std::string why =
        reader->faults().empty() ? "it has no tables 'topics' and 'messages'" : reader->faults().front();
    return fail(Errc::malformed, "'" + path + "' is no recording of rosbag2: " + why);
  }
  reader->read_topics();
  reader->read_definitions();
  reader->rewind(0, nullptr);
  return reader;
}

Db3Reader::Statement Db3Reader::prepare(const std::string& sql) {
  sqlite3_stmt* made = nullptr;
  if (sqlite3_prepare_v2(database_.get(), sql.c_str(), -1, &made, nullptr) != SQLITE_OK)
    add_fault(std::string("SQLite: ") + sqlite3_errmsg(database_.get()));
  return Statement(made);
}

/// Moves to the next row. Returns false if there is none, or if it cannot be read.
bool Db3Reader::step(const Statement& statement) {
  const int code = statement == nullptr ? SQLITE_DONE : sqlite3_step(statement.get());
  if (code != SQLITE_ROW && code != SQLITE_DONE)
    add_fault(std::string("SQLite: ") + sqlite3_errmsg(database_.get()));
  return code == SQLITE_ROW;
}

/// Returns true if the file has a table of that name. A view does not count, since its query might never
/// end.
bool Db3Reader::has_table(const char* name) {
  return step(
      prepare(std::string("SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = '") + name + "'"));
}

void Db3Reader::read_topics() {
  const bool has_qos =
      step(prepare("SELECT 1 FROM pragma_table_info('topics') WHERE name = 'offered_qos_profiles'"));
  const Statement topics = prepare(std::string("SELECT id, name, type, serialization_format") +
                                   (has_qos ? ", offered_qos_profiles" : "") + " FROM topics ORDER BY id");
  std::map<std::string, std::uint16_t> schema_of;
  while (step(topics)) {
    if (channels_.size() == UINT16_MAX) {
      add_fault("it has more than 65535 topics; the others are left out");
      break;
    }
    const std::string type = text_at(topics.get(), 2);
    const auto [schema, is_new] =
        schema_of.try_emplace(type, static_cast<std::uint16_t>(schema_of.size() + 1));
    if (is_new) schemas_[schema->second] = {.id = schema->second, .name = type};
    const auto id = static_cast<std::uint16_t>(channels_.size() + 1);
    channel_of_[sqlite3_column_int64(topics.get(), 0)] = id;
    channels_[id] = {.id = id,
                     .schema = schema->second,
                     .topic = text_at(topics.get(), 1),
                     .encoding = text_at(topics.get(), 3)};
    if (has_qos) channels_[id].metadata["offered_qos_profiles"] = text_at(topics.get(), 4);
  }
}

/// Only newer files have the definitions of their types.
void Db3Reader::read_definitions() {
  if (!has_table("message_definitions")) return;
  const Statement rows =
      prepare("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions");
  std::map<std::string, Schema*> of_name;
  for (auto& [id, schema] : schemas_) of_name[schema.name] = &schema;
  while (step(rows)) {
    const auto found = of_name.find(text_at(rows.get(), 0));
    if (found == of_name.end()) continue;
    found->second->encoding = text_at(rows.get(), 1);
    found->second->data = text_at(rows.get(), 2);
  }
}

const Overview& Db3Reader::overview() {
  if (std::exchange(is_counted_, true)) return overview_;
  const Statement rows =
      prepare("SELECT topic_id, COUNT(*), MIN(timestamp), MAX(timestamp) FROM messages GROUP BY topic_id");
  while (step(rows)) {
    const auto channel = channel_of_.find(sqlite3_column_int64(rows.get(), 0));
    if (channel == channel_of_.end()) continue;
    const auto count = static_cast<std::uint64_t>(sqlite3_column_int64(rows.get(), 1));
    const auto first = static_cast<std::uint64_t>(sqlite3_column_int64(rows.get(), 2));
    const auto last = static_cast<std::uint64_t>(sqlite3_column_int64(rows.get(), 3));
    overview_.first_ns = overview_.messages == 0 ? first : std::min(overview_.first_ns, first);
    overview_.last_ns = std::max(overview_.last_ns, last);
    overview_.messages += count;
    overview_.of_channel[channel->second] = count;
  }
  return overview_;
}

void Db3Reader::rewind(std::uint64_t from_ns, const std::set<std::uint16_t>* only) {
  std::string sql = "SELECT topic_id, timestamp, data FROM messages WHERE timestamp >= " +
                    std::to_string(static_cast<std::int64_t>(from_ns));
  if (only != nullptr) {
    std::string ids;
    for (const auto& [topic, channel] : channel_of_) {
      if (only->contains(channel)) ids += (ids.empty() ? "" : ", ") + std::to_string(topic);
    }
    sql += " AND topic_id IN (" + ids + ")";
  }
  messages_ = prepare(sql + " ORDER BY timestamp, id");
}

std::optional<Message> Db3Reader::next() {
  while (step(messages_)) {
    const std::int64_t topic = sqlite3_column_int64(messages_.get(), 0);
    const auto channel = channel_of_.find(topic);
    if (channel == channel_of_.end()) {
      add_fault("topic " + std::to_string(topic) +
                " has messages, but no row in 'topics'; they are left out");
      continue;
    }
    const auto time = static_cast<std::uint64_t>(sqlite3_column_int64(messages_.get(), 1));
    const auto* const data = static_cast<const std::byte*>(sqlite3_column_blob(messages_.get(), 2));
    const auto bytes = static_cast<std::size_t>(sqlite3_column_bytes(messages_.get(), 2));
    return Message{.channel = channel->second, .log_ns = time, .publish_ns = time, .data = {data, bytes}};
  }
  return std::nullopt;
}

void Db3Reader::check() {
  const Statement rows = prepare("PRAGMA integrity_check(100)");
  while (step(rows)) {
    const std::string found = text_at(rows.get(), 0);
    if (found != "ok") add_fault("SQLite: " + found);
  }
  rewind(0, nullptr);
  while (next()) {
  }
  rewind(0, nullptr);
}

}  // namespace sft::recording
