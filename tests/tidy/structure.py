"""Finds the functions and classes of a C or C++ file by its braces.

The tokens between a brace and the end of the statement before it decide if the brace opens a namespace, a class, a
function, or something inside them (a block, an initialiser). Macros are not expanded: TEST(a, b) {} is a function.
"""

import functools
from dataclasses import dataclass, field

import lexer

_CLOSE = {"(": ")", "[": "]", "[[": "]]", "{": "}"}
_CLASS = {"class", "struct", "union"}
_ACCESS = {"public", "private", "protected"}
_TESTS = {"TEST", "TEST_F", "TEST_P", "TYPED_TEST", "TYPED_TEST_P"}
# The attributes of core/sync/thread_annotations.h.
_ATTRIBUTES = {"SFT_GUARDED_BY", "SFT_PT_GUARDED_BY", "SFT_REQUIRES", "SFT_EXCLUDES", "SFT_ACQUIRE", "SFT_RELEASE",
               "SFT_TRY_ACQUIRE", "SFT_ACQUIRED_AFTER", "SFT_ACQUIRED_BEFORE", "SFT_CAPABILITY"}
_ATTRIBUTES_ALONE = {"SFT_SCOPED_CAPABILITY", "SFT_NO_THREAD_SAFETY_ANALYSIS", "SFT_USED_ONCE", "SFT_USES"}
_AFTER_PARAMETERS = {"const", "noexcept", "override", "final", "&", "&&", "mutable", "try"}


@dataclass
class Function:
    name: str
    line: int
    lines: int


@dataclass
class Class:
    name: str
    line: int
    lines: int = 0
    data: int = 0     # the number of data members; constants (static constexpr) do not count
    methods: int = 0  # the number of declared methods; each overload counts, defaulted and deleted methods do not
    public_type: bool = False  # true if the class is in a namespace, not in a class or a function
    namespace: str = ""


@dataclass
class Name:
    name: str
    line: int
    namespace: str


@dataclass
class Structure:
    functions: list = field(default_factory=list)
    classes: list = field(default_factory=list)
    balanced: bool = True  # false if the braces of the file do not match
    enums: list = field(default_factory=list)  # enumerations in namespaces
    aliases: list = field(default_factory=list)  # aliases and concepts in namespaces


@functools.lru_cache(maxsize=None)
def read(text):
    return _Reader(list(lexer.read(text).tokens)).run()


class _Reader:
    def __init__(self, tokens):
        self.tokens = tokens
        self.at = 0
        self.found = Structure()

    def run(self):
        self._scope("namespace", None, "", is_file=True)
        return self.found

    def _scope(self, kind, owner, namespace, is_file=False):
        """Reads the statements of a scope. Returns the line of the brace that closes the scope."""
        head = []
        while self.at < len(self.tokens):
            token = self.tokens[self.at]
            self.at += 1
            if token.text == "}" and is_file:
                self.found.balanced = False
            elif token.text == "}":
                return token.line
            elif token.text == ";":
                self._statement(head, kind, owner, namespace)
                head = []
            elif token.text == ":" and len(head) == 1 and head[0].text in _ACCESS:
                head = []
            elif token.text in ("(", "[", "[["):
                if token.text == "(" and head and head[-1].text in _TESTS:
                    head[-1] = head[-1]._replace(text=f"{head[-1].text}({self._arguments()})")
                head.append(token)
                self._group(token.text, head)
                if kind == "namespace" and self._is_macro_call(head):
                    head = []
            elif token.text == "{":
                head = self._brace(token, head, kind, owner, namespace)
            else:
                head.append(token)
        self.found.balanced = self.found.balanced and is_file
        return self.tokens[-1].line if self.tokens else 1

    def _statement(self, head, kind, owner, namespace):
        if kind == "class" and head:
            _count_member(owner, _outside_angles(head))
        elif kind == "namespace":
            texts = [text for text in _outside_angles(head) if text != "template"]
            if texts[:1] in (["using"], ["concept"]) and texts[2:3] == ["="]:
                self.found.aliases.append(Name(texts[1], head[0].line, namespace))

    def _is_macro_call(self, head):
        """Returns true if the position is behind `MACRO(a, b)` without a semicolon."""
        if len(head) != 3 or not head[0].text.isupper() or self.at == len(self.tokens):
            return False
        following = self.tokens[self.at]
        return following.kind == "word" and following.line > self.tokens[self.at - 1].line

    def _arguments(self):
        """Returns the names in the parentheses of a test, such as TEST(a, b)."""
        end = self.at
        while end < len(self.tokens) and self.tokens[end].text != ")":
            end += 1
        return "".join(token.text for token in self.tokens[self.at:end]).replace(",", ", ")

    def _group(self, opening, head):
        """Skips the tokens up to the bracket that closes `opening`, and appends only that bracket to `head`."""
        closing, inside = _CLOSE[opening], []
        while self.at < len(self.tokens):
            token = self.tokens[self.at]
            self.at += 1
            if token.text == closing:
                head.append(token)
                return
            if token.text == "]]" and closing == "]":  # two brackets as in a[b[i]]
                self.tokens[self.at - 1:self.at] = [token._replace(text="]"), token._replace(text="]")]
                self.at -= 1
            elif token.text in _CLOSE:
                self._group(token.text, inside)

    def _brace(self, brace, head, kind, owner, namespace):
        """Reads the block that the brace opens. Returns the rest of the statement."""
        texts = _outside_angles(head)
        if kind in ("namespace", "class"):
            is_linkage = texts[:1] == ["extern"] and len(head) == 2
            if is_linkage or "namespace" in texts[:2]:
                self._scope("namespace", None, _inner(namespace, texts))
                return []
            if "enum" in texts[:3] and "(" not in texts:
                self._group("{", [])
                if kind == "namespace":
                    name = _type_name(texts, {"enum", "class", "struct"})
                    self.found.enums.append(Name(name, head[0].line, namespace))
                return [*head, brace]
        if _opens_class(texts):
            return self._class(brace, head, texts, kind, namespace)
        # A part of a function body with `try`.
        if kind != "block" and texts[0:2] == ["catch", "("] and self.found.functions:
            last = self.found.functions[-1]
            last.lines = self._scope("block", None, "") - last.line + 1
            return []
        if kind != "block" and _is_body(texts):
            self._function(brace, head, texts, kind, owner)
            return []
        if kind == "block" and _ends_statement(texts):
            self._scope("block", None, namespace)
            return []
        self._skip_block(head)
        return head

    def _skip_block(self, head):
        head.append(lexer.Token("symbol", "{", head[-1].line if head else 0))
        self._group("{", head)

    def _class(self, brace, head, texts, kind, namespace):
        made = Class(_type_name(texts, _CLASS), head[0].line, namespace=namespace,
                     public_type=kind == "namespace")
        self.found.classes.append(made)
        made.lines = self._scope("class", made, namespace) - made.line + 1
        return [*head[:1], brace]  # `struct { int a; } member;` is a statement that continues

    def _function(self, brace, head, texts, kind, owner):
        function = Function(_function_name(texts), head[0].line, 0)
        self.found.functions.append(function)
        function.lines = self._scope("block", None, "") - function.line + 1
        if kind == "class" and owner and head[0].text != "friend":
            owner.methods += 1


def _count_member(owner, texts):
    if texts[0] in ("using", "typedef", "friend", "static_assert", "template", "enum") and not _template_method(texts):
        return
    if texts[0] in _CLASS and len(texts) == 2:
        return  # a forward declaration, or the end of a nested class
    if _template_method(texts) or _parameters(texts):
        if texts[-1] not in ("default", "delete"):
            owner.methods += 1
    elif not ("static" in texts and "constexpr" in texts):
        owner.data += 1 + _more_declarators(texts)


def _template_method(texts):
    return texts[0] == "template" and bool(_parameters(texts))


def _more_declarators(texts):
    """Returns the number of further variables: 1 for `int a = 1, b;`, 0 for `auto a = std::pair<int, int>();`."""
    return sum(1 for i, text in enumerate(texts) if text == "," and texts[i + 1].isidentifier() and
               (i + 2 == len(texts) or texts[i + 2] in (",", "=", "{", "[", ":")))


def _outside_angles(head):
    """Returns the words of a head without template arguments, attributes, alignas(), decltype() and explicit()."""
    texts, depth, skip_group = [], 0, False
    assigned = False
    for index, token in enumerate(head):
        text = token.text
        before = texts[-1] if texts else ""
        if text == "<" and not assigned and before != "operator" and (depth or before.isidentifier()):
            depth += 1
        elif text in (">", ">>") and depth:
            depth -= 1
        elif text == ">=" and depth:  # as in std::enable_if_t<...>= 0
            depth -= 1
            assigned = depth == 0
        elif depth:
            continue
        elif text in ("alignas", "decltype", "explicit") and index + 1 < len(head) and head[index + 1].text == "(":
            skip_group = True
        elif text == "[[" or text in _ATTRIBUTES:
            skip_group = True
        elif text in _ATTRIBUTES_ALONE:
            continue
        elif skip_group:
            skip_group = text not in (")", "]]")
        else:
            assigned = assigned or text == "=" and before != "operator"
            texts.append(text)
    return texts


def _parameters(texts):
    """Returns the index of the bracket that opens the parameters of a function; None if there is none."""
    for index, text in enumerate(texts):
        if text == "=" and texts[index - 1] != "operator":
            return None
        if text == "(" and index:
            if texts[index - 1] in ("requires", "noexcept"):
                continue
            if texts[index + 1:index + 3] == [")", "("]:
                # A pointer to a function: void (*member)(int).
                return index + 2 if texts[index - 1] == "operator" else None
            return index
    return None


def _opens_class(texts):
    """Returns true for `struct A : B {`; false for `struct stat status{`, for `struct stat read() {` and for enums."""
    index = next((i for i, text in enumerate(texts) if text in _CLASS), None)
    if index is None or "enum" in texts or "=" in texts or "(" in texts:
        return False
    names = texts[index + 1:index + 3]
    return len(names) < 2 or not (names[0].isidentifier() and names[1].isidentifier()) or names[1] == "final"


def _is_body(texts):
    parameters = _parameters(texts)
    if not parameters:
        return False
    after = texts[parameters + 2:]  # the tokens behind `( )`
    if ":" in after:  # initialisers of members: `: a_(1), b_{2} {`
        return texts[-1] in (")", "}", "...")
    if "->" in after or "requires" in after:
        return True
    return all(text in _AFTER_PARAMETERS or text in "()" for text in after)


def _ends_statement(texts):
    """Returns true if the brace behind this head opens a block, and false if it opens an initialiser."""
    return not texts or texts[-1] in (")", "else", "do", "try", ":", "mutable", "noexcept", "const") or "->" in texts


def _function_name(texts):
    end = _parameters(texts)
    begin = end - 1
    if "operator" in texts[:end]:
        begin = max(i for i, text in enumerate(texts[:end]) if text == "operator")
    if begin and texts[begin - 1] == "~":
        begin -= 1
    while begin >= 2 and texts[begin - 1] == "::":
        begin -= 2
    return "".join(texts[begin:end])


def _type_name(texts, keywords):
    index = next(i for i, text in enumerate(texts) if text in keywords)
    names = []
    for text in texts[index + 1:]:
        if text in keywords:
            continue
        if text in (":", "final", "{", "("):
            break
        names.append(text)
    return "".join(names) or "(unnamed)"


def _inner(namespace, texts):
    name = "".join(text for text in texts if text not in ("namespace", "inline", "extern"))
    if texts and texts[0] == "extern":
        return namespace
    return "::".join(part for part in (namespace, name or "(unnamed)") if part)
