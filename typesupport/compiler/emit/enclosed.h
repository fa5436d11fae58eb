// Puts all types of a file into one more namespace, around their own. Their names in type tables do not
// change.
#pragma once

#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "model.h"

namespace sft::idl {

/// A copy of the declarations of a file, with other scoped names. The copy refers to the rest of the file's
/// model, and must not outlive the model.
class Enclosed {
 public:
  /// `outer` has the form "my::robot". If it is empty, the file stays as it was. Throws std::runtime_error
  /// if C++ or the generated code could not use the namespace.
  Enclosed(const sft_file& file, std::string_view outer);
  Enclosed(const Enclosed&) = delete;
  Enclosed& operator=(const Enclosed&) = delete;

  const sft_file& file() const { return file_; }

 private:
  void enclose(const char*& scoped);

  const std::string prefix_;  ///< the namespace as a prefix, such as "::my::robot"
  std::deque<std::string> names_;
  std::deque<std::vector<sft_member>> members_;
  std::vector<sft_declaration> declarations_;
  sft_file file_;
};

/// Returns the name of a declaration or type of the file in type tables: "sensor_msgs::msg::Imu" for
/// "::my::robot::sensor_msgs::msg::Imu".
std::string_view idl_name(const sft_file& file, std::string_view scoped);

/// Returns the folder with which the includes of types in that namespace begin: "my/robot/".
std::string folder_of_namespace(std::string_view outer);

}  // namespace sft::idl
