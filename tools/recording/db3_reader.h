// Reads the SQLite files of rosbag2. The files may be hostile, or rosbag2 may still be writing them.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "sft/result.h"
#include "tools/recording/recording.h"

struct sqlite3;
struct sqlite3_stmt;

namespace sft::recording {

class Db3Reader final : public Recording {
 public:
  /// Opens the file. Returns Errc::malformed if the file has no tables of rosbag2.
  static Result<std::unique_ptr<Db3Reader>> open(const std::string& path);

  std::string format() const override { return "rosbag2 (SQLite)"; }
  const Overview& overview() override;
  void rewind(std::uint64_t from_ns, const std::set<std::uint16_t>* only) override;
  std::optional<Message> next() override;
  void check() override;

 private:
  struct Close {
    void operator()(sqlite3* database) const;
    void operator()(sqlite3_stmt* statement) const;
  };
  using Statement = std::unique_ptr<sqlite3_stmt, Close>;

  explicit Db3Reader(sqlite3* database);
  Statement prepare(const std::string& sql);
  bool step(const Statement& statement);
  bool has_table(const char* name);
  void read_topics();
  void read_definitions();

  std::unique_ptr<sqlite3, Close> database_;
  Statement messages_{};
  std::map<std::int64_t, std::uint16_t> channel_of_{};  ///< channels by the ids of their topics
  Overview overview_{};
  bool is_counted_ = false;
};

}  // namespace sft::recording
