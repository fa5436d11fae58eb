"""The public headers: their includes, and the types that they define in public namespaces."""

import structure


def public_headers(tree, settings):
    return [path for path in tree.code if path.startswith(tuple(folder + "/" for folder in settings.public_folders))]


def is_detail(path):
    return "/detail/" in path


def public_types(tree, settings):
    """Yields (file, line, name) of classes, enums, aliases and concepts in namespaces other than detail."""
    for path in public_headers(tree, settings):
        found = structure.read(tree.text(path))
        types = [(c.line, c.name, c.namespace) for c in found.classes if c.public_type]
        types += [(other.line, other.name, other.namespace) for other in found.enums + found.aliases]
        for line, name, namespace in sorted(set(types)):
            if not is_detail(path) and not _hidden(namespace) and name.isidentifier():
                yield path, line, name


def _hidden(namespace):
    return any(part in ("detail", "internal", "(unnamed)") for part in namespace.split("::"))
