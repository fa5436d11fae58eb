// A struct of the model, with the C++ names of its fields and constants.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "model.h"

namespace sft::idl {

struct Field {
  const sft_member* idl;
  std::string name;
};

struct Constant {
  const sft_declaration* idl;
  std::string name;
};

/// A struct. The object refers to the model, and must not outlive it.
struct Message {
  std::string_view idl_name;  ///< the name in IDL, such as "sensor_msgs::msg::PointCloud2"
  std::string name;           ///< the name in C++, "PointCloud2"
  std::string qualified;      ///< the name in C++, "::sensor_msgs::msg::PointCloud2"
  std::vector<Constant> constants;
  std::vector<Field> fields;

  /// `qualified` without the leading "::", which C++ does not allow where a nested class is defined at global
  /// scope.
  std::string_view class_head() const { return std::string_view(qualified).substr(2); }
};

/// Returns the message of `declaration`, a struct of `file`. Constants of a struct X are those in the module
/// X_Constants of the same scope, as in ROS.
Message make_message(const sft_file& file, const sft_declaration& declaration);

/// Returns true if a constant belongs to a struct of this file. If not, the constant belongs to its
/// namespace.
bool belongs_to_struct(const sft_file& file, const sft_declaration& constant);

/// Returns true if a loan can reserve the field to be written in place: a sequence of primitives or
/// enumerations.
bool is_reservable(const Field& field);

/// Returns true if the view gets a function points(). A call of it compiles only if the fields also have
/// the types of a cloud.
bool is_cloud(const Message& message);

/// Returns true if LoanSizes and LoanView have a member for the field: the field is reservable, or is a
/// struct, which may contain such fields.
bool has_loan_size(const Field& field);

}  // namespace sft::idl
