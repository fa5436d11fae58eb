#!/usr/bin/env python3
"""Tests of tests/tidy. In a small tree, each check reports the places that break its rule, and nothing else."""

import os
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True

import checks
import comments
import figures
import headers
import rooms
import structure
from settings import FILE, Settings
from tree import Tree

ROOMS = """
[rooms]
"public/..." = { holds = "headers of users", includes = [] }
"low" = { holds = "the ground floor", includes = ["public/..."] }
"left" = { holds = "one wing", includes = ["low"] }
"right" = { holds = "the other wing", includes = ["low"] }
"high" = { holds = "the roof", includes = ["left", "right"] }

[limits]
file_lines = 20
function_lines = 4
data_members = 2
methods = 2
public_types = 2

[columns]
".md" = 20
".h" = 30

[public]
folders = ["public"]
libraries = ["tl/expected.hpp"]

[comments]
names = ["sftd"]

[words]
"whatsoeverish" = "write a number"

[metaphors]
"earlike" = "write receiver"
"""


class TreeTest(unittest.TestCase):
    """Each test writes a tree. found() returns the places that a check finds in the tree, as `path:line`."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = folder.name
        self.write(FILE, ROOMS)

    def write(self, path, text):
        full = os.path.join(self.root, path)
        os.makedirs(os.path.dirname(full), exist_ok=True)
        with open(full, "w", encoding="utf-8") as file:
            file.write(text)

    def found(self, name):
        return [f"{finding.path}:{finding.line}"
                for finding in checks.ALL[name](Tree(self.root), Settings(self.root))]


class IncludesTest(TreeTest):
    def test_a_room_includes_its_own_files_and_those_below_it(self):
        self.write("low/a.h", '#include <public.h>\n#include "low/b.h"\n')
        self.write("low/b.h", "")
        self.write("public/public.h", "")
        self.write("high/c.h", '#include "low/a.h"\n#include "left/d.h"\n')
        self.write("left/d.h", "")
        self.assertEqual(self.found("includes-go-only-downward"), [])

    def test_an_include_upward_is_found(self):
        self.write("low/a.h", '\n#include "high/b.h"\n')
        self.write("high/b.h", "")
        self.assertEqual(self.found("includes-go-only-downward"), ["low/a.h:2"])

    def test_an_include_sideways_is_found(self):
        self.write("left/a.h", '#include "right/b.h"\n')
        self.write("right/b.h", "")
        self.assertEqual(self.found("includes-go-only-downward"), ["left/a.h:1"])

    def test_a_file_outside_of_all_rooms_is_found(self):
        self.write("low/cellar/a.h", "")
        self.assertEqual(self.found("includes-go-only-downward"), ["low/cellar/a.h:1"])

    def test_a_room_that_names_one_below_it_in_the_table_is_found(self):
        self.write(FILE, ROOMS.replace('floor", includes = [', 'floor", includes = ["high", '))
        self.assertEqual(self.found("includes-go-only-downward"), [FILE + ":1"])

    def test_a_library_in_another_folder_than_its_own_is_found(self):
        self.write(FILE, ROOMS + '[libraries]\n"bus/" = ["low"]\n')
        self.write("low/deep/a.h", "#include <bus/bus.h>\n")
        self.write("left/b.h", '#include <bus>\n#include "bus/bus.h"\n')
        self.write("lower/c.h", "#include <bus/bus.h>\n")
        self.assertEqual(self.found("libraries-stay-in-their-folders"), ["left/b.h:2", "lower/c.h:1"])

    def test_an_include_in_a_comment_is_none(self):
        self.write("low/a.h", '// #include "high/b.h"\n')
        self.write("high/b.h", "")
        self.assertEqual(self.found("includes-go-only-downward"), [])

    def test_a_room_without_files_is_found(self):
        for room in ("public", "low", "left", "right"):
            self.write(f"{room}/a.h", "")
        self.assertEqual(self.found("rooms-exist"), [FILE + ":1"])

    def test_pairs_that_include_each_other_by_their_sources_are_a_knot(self):
        self.write("low/a.h", "")
        self.write("low/b.h", '#include "low/a.h"\n')
        self.assertEqual(self.found("file-pairs-form-no-knots"), [])
        self.write("low/a.cpp", '#include "low/a.h"\n#include "low/b.h"\n')
        self.assertEqual(self.found("file-pairs-form-no-knots"), ["low/a:1"])

    def test_a_circle_of_three_pairs_is_one_knot(self):
        for one, other in ("ab", "bc", "ca"):
            self.write(f"low/{one}.h", f'#include "low/{other}.h"\n')
        self.assertEqual(rooms.knots(rooms.Includes(Tree(self.root), Settings(self.root))),
                         [["low/a", "low/b", "low/c"]])

    def test_project_headers_are_included_from_the_root_in_double_quotes(self):
        self.write("public/p.h", "")
        self.write("low/b.h", "")
        self.write("low/a.h", '#include <p.h>\n#include "p.h"\n#include "low/b.h"\n#include <vector>\n'
                              '#include "b.h"\n#include <low/b.h>\n#include "public/p.h"\n')
        self.assertEqual(self.found("includes-have-one-style"), ["low/a.h:5", "low/a.h:6", "low/a.h:7"])

    def test_an_include_of_a_file_that_has_moved_is_found(self):
        self.write("low/a.h", '#include "low/moved.h"\n#include "generated.h"\n#include "std_msgs/msg/Header.h"\n')
        self.assertEqual(self.found("includes-have-one-style"), ["low/a.h:1"])

    def test_public_headers_include_public_ones_the_language_and_declared_libraries(self):
        self.write("low/b.h", "")
        self.write("public/p.h", '#include <vector>\n#include <stdint.h>\n#include "q.h"\n#include <tl/expected.hpp>\n'
                                 '#include "low/b.h"\n#include <fmt/format.h>\n')
        self.write("public/q.h", "")
        self.assertEqual(self.found("public-headers-include-public-ones"), ["public/p.h:5", "public/p.h:6"])


class ListsTest(TreeTest):
    def test_a_source_may_be_named_by_its_own_list_one_above_or_by_a_pattern(self):
        self.write("low/CMakeLists.txt", "add_library(low a.cpp deep/b.c ${parts}/c.cpp)\nfile(GLOB more d_*.cpp)\n")
        for path in ("low/a.cpp", "low/deep/b.c", "high/parts/c.cpp", "low/d_1.cpp"):
            self.write(path, "")
        self.assertEqual(self.found("sources-are-in-cmake-lists"), [])

    def test_a_source_that_is_named_nowhere_or_in_a_comment_only_is_found(self):
        self.write("low/CMakeLists.txt", "add_library(low ba.cpp)  # a.cpp\n")
        self.write("low/a.cpp", "")
        self.write("high/ba.cpp", "")
        self.assertEqual(self.found("sources-are-in-cmake-lists"), ["high/ba.cpp:1", "low/a.cpp:1"])


class LinesTest(TreeTest):
    def test_lines_that_are_too_wide_are_found_but_tables_and_addresses_are_not(self):
        self.write("a.md", "x" * 20 + "\n" + "x" * 21 + "\n| " + "x" * 30 + "\nhttps://" + "x" * 30 + "\n")
        self.assertEqual(self.found("lines-fit-their-columns"), ["a.md:2"])

    def test_words_of_the_list_are_found_in_code_and_documents(self):
        self.write("a.md", "fine\nWhatsoeverish\n")
        self.write("low/a.h", "// whatsoeverish\n")
        self.assertEqual(self.found("words-are-plain"), ["low/a.h:1", "a.md:2"])


class NamesTest(TreeTest):
    def test_a_metaphor_in_a_name_is_found_but_in_no_comment_string_or_sentence(self):
        self.write("low/a.h", 'int my_earlike;\n// earlike\nauto s = "earlike";\nint TheEarlikeHearsAll;\n'
                              "EarlikeBox b;\n")
        self.assertEqual(self.found("identifiers-are-words-of-the-trade"), ["low/a.h:1", "low/a.h:5"])

    def test_a_word_of_the_list_is_found_in_the_name_of_a_test(self):
        self.write("low/a.h", "int TheWhatsoeverishReaderHearsAll;\n")
        self.assertEqual(self.found("identifiers-are-words-of-the-trade"), ["low/a.h:1"])

    def test_a_trailing_comment_of_one_word_is_found(self):
        self.write("low/a.h", "int a;  ///< likewise\nint b;  ///< the number of ears\nint c;  ///< id()\n")
        self.assertEqual(self.found("trailing-comments-have-a-noun"), ["low/a.h:1"])


class SizesTest(TreeTest):
    def test_what_is_within_the_limits_is_not_found(self):
        self.write("low/a.h", "struct A {\n  int a, b;\n  void f();\n  void g() {}\n};\nvoid h() {\n\n\n}\n")
        self.assertEqual(self.found("sizes-are-within-limits"), [])

    def test_a_long_function_file_or_class_is_found(self):
        self.write("low/a.h", "void h() {\n\n\n\n}\n")
        self.write("low/b.h", "struct A {\n  int a, b;\n  int c;\n};\nstruct B { void f(); void g(); B(); };\n")
        self.write("low/c.h", "\n" * 21)
        self.assertEqual(self.found("sizes-are-within-limits"),
                         ["low/a.h:1", "low/b.h:1", "low/b.h:5", "low/c.h:1"])

    def test_a_reason_beside_it_permits_a_larger_function_file_or_class(self):
        self.write("low/a.h", "int a;\n/// It waits.\n/// Larger than usual: a list.\nvoid h() {\n\n\n\n}\n")
        self.write("low/b.h", "/// Larger than usual: a record.\n/// It is sent.\nstruct A {\n  int a, b, c;\n};\n")
        self.write("low/c.h", "// A table.\n// Larger than usual: it is long.\n" + "\n" * 21)
        self.assertEqual(self.found("sizes-are-within-limits"), [])

    def test_a_reason_elsewhere_does_not_count_and_one_that_is_not_needed_any_more_is_found(self):
        self.write("low/a.h", "/// Larger than usual: a list.\n\nvoid h() {\n\n\n\n}\n")
        self.write("low/b.h", "/// Larger than usual: a record.\nstruct A {\n  int a;\n};\n")
        self.write("low/c.h", "/// Larger than usual:\nstruct A {\n  int a, b, c;\n};\n")
        self.assertEqual(self.found("sizes-are-within-limits"), ["low/a.h:3", "low/a.h:1", "low/b.h:1", "low/c.h:2"])

    def test_more_public_types_than_the_limit_are_found_and_nested_or_private_ones_do_not_count(self):
        self.write("public/p.h", "namespace sft {\nstruct A { struct B {}; enum class C { x }; };\nusing D = A;\n"
                                 "namespace detail {\nstruct E {};\n}\n}\n")
        self.write("low/a.h", "namespace sft {\nstruct F {};\n}\n")
        self.assertEqual(self.found("public-types-are-few"), [])
        self.write("public/q.h", "namespace sft {\nenum class G { x };\n}\n")
        self.assertEqual(self.found("public-types-are-few"), [FILE + ":1"])


class StructureTest(unittest.TestCase):
    def functions(self, text):
        return [(function.name, function.lines) for function in structure.read(text).functions]

    def members(self, text):
        return [(made.name, made.data, made.methods) for made in structure.read(text).classes]

    def test_functions_end_at_their_own_brace(self):
        text = """int f() {
  if (a) {
  } else {
  }
  auto g = [] { return 1; };
}
int h() {}
"""
        self.assertEqual(self.functions(text), [("f", 6), ("h", 1)])

    def test_initialisers_of_members_and_variables_are_no_bodies(self):
        text = """A::A(int x) : a_{x}, b_(x), C<int>{1} {
  g();
}
const std::map<int, F> m{
    {1, f(2)}};
"""
        self.assertEqual(self.functions(text), [("A::A", 3)])

    def test_operators_templates_tests_and_bodies_with_try_are_functions(self):
        text = """template <class T>
  requires requires(T t) { t.f(); }
bool operator<(const A<T>& a, T b) noexcept { return a < b; }
A& A::operator=(A&&) = default;
auto A::operator()(int) const -> std::vector<int> { return {}; }
TEST_F(LaneTest, Ends) {}
void A::f() try {
} catch (const std::exception&) {
}
A::~A() {}
"""
        self.assertEqual(self.functions(text), [("operator<", 3), ("A::operator()", 1), ("TEST_F(LaneTest, Ends)", 1),
                                                ("A::f", 3), ("A::~A", 1)])

    def test_text_in_strings_comments_and_macros_opens_nothing(self):
        text = """#define F() {
void f() {
  g("{", '{', R"({)");  // {
  /* { */
}
"""
        self.assertEqual(self.functions(text), [("f", 4)])

    def test_attributes_of_locks_change_neither_members_nor_functions(self):
        text = """class SFT_CAPABILITY("mutex") Mutex {
  void lock() SFT_ACQUIRE() { mutex_.lock(); }
  std::mutex mutex_;
};
class SFT_SCOPED_CAPABILITY Lock {
  int f() const SFT_REQUIRES(mutex_) SFT_EXCLUDES(other_);
  int g() SFT_REQUIRES(mutex_) {
    return a_;
  }
  int a_ SFT_GUARDED_BY(mutex_) = 0;
  std::map<int, int> b_ SFT_GUARDED_BY(mutex_){};
  Mutex c_ SFT_ACQUIRED_AFTER(first) SFT_ACQUIRED_BEFORE(second, third);
};
"""
        classes = [(c.name, c.data, c.methods) for c in structure.read(text).classes]
        self.assertEqual(classes, [("Mutex", 1, 1), ("Lock", 3, 2)])
        self.assertEqual(self.functions(text), [("lock", 1), ("g", 3)])

    def test_members_are_data_without_constants_and_methods_without_defaulted_ones(self):
        text = """class A final : public B<int, int> {
 public:
  explicit A(int a);
  A(const A&) = delete;
  ~A() override = default;
  virtual void f(std::function<void(int)> g = {}) = 0;
  template <class T> void h(T t) { t(); }
  friend bool operator==(const A&, const A&) { return true; }
  using C = int;
  enum class D { x, y };
  struct E { int z; };
 private:
  static constexpr int max = 4;
  std::function<void(int)> g_;
  alignas(64) std::atomic<int> a_{0};
  int b_ = std::max<int>(1, 2), c_{3};
  std::pair<int, int> p_ = std::pair<int, int>{1, 2};
  void (*hook_)(int) = nullptr;
};"""
        self.assertEqual(self.members(text), [("A", 6, 3), ("E", 1, 0)])

    def test_a_variable_of_a_struct_of_c_is_no_class(self):
        text = """struct stat status{};
void f() {
  struct stat opened {};
  struct sockaddr_in a = {0};
}
"""
        self.assertEqual(self.members(text), [])

    def test_braces_of_two_branches_of_the_preprocessor_do_not_match(self):
        self.assertFalse(structure.read("#if A\nvoid f() {\n#else\nvoid g() {\n#endif\n}\n}\n}\n").balanced)
        self.assertTrue(structure.read("namespace a {\nvoid f() {}\n}\n").balanced)


class CommentsTest(TreeTest):
    def fragments(self, text):
        names = comments.names_in(text) | {"sftd"}
        return [block.line for block in comments.blocks(text) if comments.begins_in_mid_sentence(block, names)]

    def test_a_block_that_begins_in_mid_sentence_is_counted_once(self):
        text = """int a;
/// Of the last message
/// of the thread.
int b;
// What it is.
"""
        self.assertEqual(self.fragments(text), [2, 5])

    def test_a_small_letter_counts_unless_it_begins_a_name(self):
        self.assertEqual(self.fragments("// for tests\n"), [1])
        self.assertEqual(self.fragments("// the rest\n"), [1])
        self.assertEqual(self.fragments("// sftd's files\nint a;\n// send() waits.\nint b;\n"), [])
        self.assertEqual(self.fragments("// io_uring is not there.\nint a;\n// tail is here\nint tail;\n"), [])

    def test_clauses_with_a_comma_and_sentences_with_a_subject_do_not_count(self):
        text = """// When the window is full, the sender waits.
int a;
// The rest.
int b;
// When seen.
"""
        self.assertEqual(self.fragments(text), [5])

    def test_comments_behind_code_and_of_members_do_not_count(self):
        text = """int a;  ///< of the last
        ///< of them
int b;  // of it
/* of it */
"""
        self.assertEqual(self.fragments(text), [])

    def test_a_twentieth_of_all_blocks_is_too_many(self):
        self.write("low/a.h", "// The rest.\n\n" * 20 + "// Of it.\n")
        self.assertEqual(self.found("comments-begin-with-their-subject"), [])
        self.write("low/a.h", "// The rest.\n\n" * 19 + "// Of it.\n")
        self.assertEqual(self.found("comments-begin-with-their-subject"), ["low/a.h:39"])


class FiguresTest(TreeTest):
    def test_the_table_counts_lines_words_and_public_types(self):
        self.write("README.md", "Two words\n```\nthree of code\n```\n")
        self.write("core/a.h", "// A comment\n\nint a;  // and code\n/* two\nlines */\n")
        self.write("public/p.h", "namespace sft {\nclass A;\nclass B { struct C {}; };\nenum class D { x };\n"
                                 "template <class T>\nusing F = B<T>;\nusing B;\n"
                                 "namespace detail {\nstruct E {};\n}\n}\n")
        tree, settings = Tree(self.root), Settings(self.root)
        table = "\n".join(" ".join(line.split()) for line in figures.table(tree, settings))
        self.assertIn("README.md 2 words, 5 in blocks of code, 4 lines", table)
        self.assertIn("lines of the product 5: code 1, comments 3, blank 1", table)
        self.assertEqual([name for _, _, name in headers.public_types(tree, settings)], ["B", "D", "F"])


if __name__ == "__main__":
    unittest.main()
