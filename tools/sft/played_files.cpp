#include "tools/sft/played_files.h"

#include <algorithm>
#include <utility>

namespace sft::tool {

namespace {

// The maximum number of bytes that are read ahead
constexpr std::uint64_t ahead_most = std::uint64_t{64} << 20;

}  // namespace

PlayedFiles::PlayedFiles(std::vector<std::unique_ptr<recording::Recording>> files)
    : files_(std::move(files)), heads_(files_.size()) {}

PlayedFiles::~PlayedFiles() { stop(); }

void PlayedFiles::rewind(std::uint64_t from_ns, const std::vector<std::set<std::uint16_t>>& only) {
  for (std::size_t i = 0; i < files_.size(); ++i) {
    files_[i]->rewind(from_ns, &only[i]);
    heads_[i] = files_[i]->next();
  }
}

std::optional<PlayedFiles::Message> PlayedFiles::read() {
  std::size_t first = files_.size();
  for (std::size_t i = 0; i < files_.size(); ++i) {
    const bool is_earlier =
        heads_[i] && (first == files_.size() || heads_[i]->log_ns < heads_[first]->log_ns);
    if (is_earlier) first = i;
  }
  if (first == files_.size()) return std::nullopt;
  Message message{first, *heads_[first], {heads_[first]->data.begin(), heads_[first]->data.end()}};
  message.message.data = message.data;
  heads_[first] = files_[first]->next();
  return message;
}

void PlayedFiles::start(std::uint64_t from_ns, const std::vector<std::set<std::uint16_t>>& only) {
  stop();
  ahead_.clear();
  ahead_bytes_ = 0;
  at_end_ = stops_ = false;
  rewind(from_ns, only);
  thread_ = std::thread([this] { run(); });
}

void PlayedFiles::stop() {
  if (!thread_.joinable()) return;
  {
    const std::scoped_lock lock(mutex_);
    stops_ = true;
    changed_.notify_all();
  }
  thread_.join();
}

void PlayedFiles::run() {
  for (;;) {
    std::optional<Message> message = read();
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return stops_ || ahead_bytes_ < ahead_most; });
    at_end_ = !message.has_value();
    changed_.notify_all();
    if (stops_ || at_end_) return;
    ahead_bytes_ += message->data.size() + sizeof(Message);
    ahead_.push_back(*std::move(message));
  }
}

std::optional<PlayedFiles::Message> PlayedFiles::next() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !ahead_.empty() || at_end_; });
  if (ahead_.empty()) return std::nullopt;
  Message message = std::move(ahead_.front());
  ahead_.pop_front();
  ahead_bytes_ -= message.data.size() + sizeof(Message);
  changed_.notify_all();
  return message;
}

}  // namespace sft::tool
