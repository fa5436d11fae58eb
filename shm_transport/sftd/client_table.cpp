#include "shm_transport/sftd/client_table.h"

#include <poll.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>

namespace sft::shm {

namespace {

constexpr std::chrono::seconds round_interval{1};

bool has_exited(const Descriptor& process) {
  pollfd state{process.get(), POLLIN, 0};
  return poll(&state, 1, 0) > 0;
}

}  // namespace

bool ClientTable::is_dead(const std::string& name, const Process& process, bool exited) {
  if (exited && process.has_own_pids) return true;
  const std::string path = "/tmp/" + name;
  const SocketState state = socket_state_at(path.c_str());
  if (state != SocketState::gone) return state == SocketState::unknown && exited;
  // A process that is killed leaves its socket. A process that ends normally is removed from the table by
  // its goodbye before it removes its socket. So if there is no socket, another process has removed it.
  struct stat socket {};
  const bool removed = lstat(path.c_str(), &socket) != 0 && errno == ENOENT;
  return !removed || exited || !*process.life;
}

void ClientTable::add(const std::string& name, pid_t pid) {
  auto life = std::make_shared<const Descriptor>(static_cast<int>(syscall(SYS_pidfd_open, pid, 0)));
  const bool has_own_pids = !own_mark_.empty() && name.ends_with(own_mark_);
  const core::Lock lock(mutex_);
  clients_.insert_or_assign(name, Process{pid, has_own_pids, std::move(life)});
}

void ClientTable::remove(const std::string& name) {
  const core::Lock lock(mutex_);
  clients_.erase(name);
}

bool ClientTable::empty() const {
  const core::Lock lock(mutex_);
  return clients_.empty();
}

std::size_t ClientTable::size() const {
  const core::Lock lock(mutex_);
  return clients_.size();
}

std::vector<ClientTable::Client> ClientTable::all() const {
  const core::Lock lock(mutex_);
  std::vector<Client> clients;
  for (const auto& [name, process] : clients_) clients.push_back({name, process.pid});
  return clients;
}

std::vector<std::string> ClientTable::find_dead(Clock::time_point now) {
  std::map<std::string, Process> clients;
  {
    const core::Lock lock(mutex_);
    clients = clients_;
  }
  std::vector<pollfd> processes;
  for (const auto& [name, process] : clients) processes.push_back({process.life->get(), POLLIN, 0});
  poll(processes.data(), processes.size(), 0);
  const bool full_round = now >= next_round_;
  if (full_round) next_round_ = now + round_interval;

  std::vector<std::string> dead;
  auto polled = processes.begin();
  for (const auto& [name, process] : clients) {
    const bool exited = (polled++)->revents != 0;
    if ((full_round || exited) && is_dead(name, process, exited)) dead.push_back(name);
  }
  return dead;
}

bool ClientTable::is_gone(const std::string& name) const {
  Process process;
  {
    const core::Lock lock(mutex_);
    const auto client = clients_.find(name);
    if (client == clients_.end()) return true;
    process = client->second;
  }
  return is_dead(name, process, has_exited(*process.life));
}

}  // namespace sft::shm
