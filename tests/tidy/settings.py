"""Reads tests/tidy/rooms.toml."""

import os
import tomllib

FILE = "tests/tidy/rooms.toml"


class Settings:
    """The table of the examined checkout. If the checkout has none, the table beside this script."""

    def __init__(self, root):
        self.file = FILE
        own = os.path.join(os.path.dirname(os.path.abspath(__file__)), "rooms.toml")
        path = os.path.join(root, FILE)
        with open(path if os.path.exists(path) else own, "rb") as file:
            data = tomllib.load(file)
        self.rooms = data.get("rooms", {})
        self.limits = data.get("limits", {})
        self.libraries = data.get("libraries", {})
        self.columns = data.get("columns", {})
        self.public_folders = data.get("public", {}).get("folders", [])
        self.public_libraries = data.get("public", {}).get("libraries", [])
        self.words = data.get("words", {})
        self.metaphors = data.get("metaphors", {})
        self.unlisted = data.get("unlisted_sources", {})
        self.private_folders = data.get("private_include_folders", {})
        self.names = set(data.get("comments", {}).get("names", []))
