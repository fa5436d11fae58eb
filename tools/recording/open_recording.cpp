#include "tools/recording/open_recording.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <system_error>
#include <utility>

#include "sft/msg_text.h"
#include "tools/recording/db3_reader.h"
#include "tools/recording/file.h"
#include "tools/recording/idl_text.h"
#include "tools/recording/mcap_reader.h"

namespace sft::recording {

namespace {

bool is_db3(File& file) {
  constexpr std::string_view begin = "SQLite format 3";
  return std::ranges::equal(file.look(0, begin.size()), bytes_of(begin));
}

/// Removes repeated definitions, because rosbag2 has written a nested type once for each use.
std::string without_repetitions(const std::string& text) {
  const std::string separator(80, '=');
  std::string all = text.substr(0, text.find(separator));
  std::set<std::string> known;
  for (std::size_t at = all.size(); at < text.size();) {
    const std::size_t end = std::min(text.find(separator, at + 1), text.size());
    std::string definition = text.substr(at, end - at);
    const std::size_t name = definition.find("MSG: ");
    const std::size_t line_end = std::min(definition.find('\n', name), definition.size());
    const bool has_name = name != definition.npos;
    if (!has_name || known.insert(definition.substr(name, line_end - name)).second) all += definition;
    at = end;
  }
  return all;
}

}  // namespace

Result<std::unique_ptr<Recording>> open_recording(const std::string& path) {
  Result<std::vector<std::string>> files = files_of(path);
  if (!files) return tl::unexpected(files.error());
  if (files->size() != 1)
    return fail(Errc::invalid_argument,
                "'" + path + "' has " + std::to_string(files->size()) + " recordings: name one of its files");
  Result<File> file = File::open(files->front());
  if (!file) return tl::unexpected(file.error());
  if (is_db3(*file)) {
    return Db3Reader::open(files->front()).map([](auto&& reader) {
      return std::unique_ptr<Recording>(std::move(reader));
    });
  }
  return McapReader::open(*std::move(file)).map([](auto&& reader) {
    return std::unique_ptr<Recording>(std::move(reader));
  });
}

Result<std::vector<std::string>> files_of(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (!fs::is_directory(path, error)) return std::vector{path};
  std::vector<std::string> files;
  for (fs::directory_iterator at(path, error), end; !error && at != end; at.increment(error)) {
    const std::string extension = at->path().extension().string();
    if (extension == ".mcap" || extension == ".db3") files.push_back(at->path().string());
  }
  if (error) return fail(Errc::system, "'" + path + "' cannot be read: " + error.message());
  if (files.empty()) return fail(Errc::unavailable, "'" + path + "' has no .mcap and no .db3 file");
  // The names of split files end with a number. The file with the number 10 comes after the file with the
  // number 9.
  std::ranges::sort(files, [](const std::string& a, const std::string& b) {
    return std::pair(a.size(), a) < std::pair(b.size(), b);
  });
  return files;
}

Result<DynamicType> type_of(const Schema& schema) {
  if (schema.encoding == "ros2msg") return from_msg(schema.name, without_repetitions(schema.data));
  if (schema.encoding == "ros2idl") {
    return msg_of_idl(schema.name, schema.data).and_then([&](const std::string& text) {
      return from_msg(schema.name, text);
    });
  }
  return fail(Errc::unavailable, "the recording has no definition of " + schema.name +
                                     (schema.encoding.empty() ? "" : " but one in " + schema.encoding));
}

}  // namespace sft::recording
