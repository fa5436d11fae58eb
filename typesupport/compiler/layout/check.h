// Layout rules for the reader of IDL, which is C: idlc's headers are no C++.
#pragma once

#include "model.h"

#ifdef __cplusplus
extern "C" {
#endif

enum sft_shape { SFT_SINGLE, SFT_ARRAY, SFT_SEQUENCE };

/// A member of a struct, as far as rules look at it.
struct sft_seen {
  const char* name;  ///< null: there is none
  enum sft_kind kind;
  enum sft_shape shape;
  const void* type;  ///< of a structure
};

/// The i-th member of a struct.
typedef struct sft_seen (*sft_see)(const void* type, size_t i);

/// The rule of the i-th member of the struct that is checked, as written.
struct sft_rule {
  size_t member;
  const char* text;
};

/// A mistake in a rule. Its text lies in this struct.
struct sft_rule_fault {
  size_t rule;  ///< its number in the list
  size_t at;    ///< in the text of the rule, in bytes
  char text[400];
};

/// The one spelling of a rule. The caller frees it. Null if the rule is wrong, which `fault` then says.
char* sft_layout_text(const char* text, struct sft_rule_fault* fault);

/// False if one of the rules, each of which sft_layout_text() has accepted, does not suit the struct.
bool sft_check_layouts(sft_see see, const void* type, const struct sft_rule* rules, size_t count,
                       struct sft_rule_fault* fault);

#ifdef __cplusplus
}
#endif
