"""YAML of ROS 2 parameter files: read so that nothing is lost, written as ROS 2 takes it.

The only place that knows the library, so that every file is read alike.
"""

from typing import Any

import yaml
from yaml import YAMLError
from yaml.events import AliasEvent
from yaml.nodes import MappingNode, Node, ScalarNode

__all__ = [
    "MappingNode",
    "ScalarNode",
    "YAMLError",
    "yaml_content",
    "yaml_node",
    "yaml_number",
    "yaml_string",
]


class _Loader(yaml.SafeLoader):
    """Refuses what is given twice, of which the base class drops the first, and aliases.

    ROS 2 takes no aliases (`*name`); a few lines of nested ones stand for more than memory holds.
    """

    def compose_node(self, parent: Node | None, index: Any) -> Node | None:
        """Return what comes next, unless it is an alias."""
        if self.check_event(AliasEvent):
            event = self.peek_event()  # type: ignore[no-untyped-call]
            line = event.start_mark.line + 1
            raise YAMLError(
                f"*{event.anchor} in line {line}: ROS 2 takes no aliases; write out what it means"
            )
        return super().compose_node(parent, index)

    def compose_mapping_node(self, anchor: Any) -> MappingNode:
        """Return a mapping, if no key stands twice in it."""
        node = super().compose_mapping_node(anchor)
        lines: dict[str, int] = {}
        for key, _ in node.value:
            if not isinstance(key, ScalarNode):
                continue
            line = key.start_mark.line + 1
            if key.value in lines:  # names of parameters are text, so 1 is '1' here
                raise YAMLError(
                    f"{key.value} is given in line {lines[key.value]} and again in line {line}; "
                    "put them together"
                )
            lines[key.value] = line
        return node


def yaml_content(text: str) -> object:
    """Return what YAML text says.

    Raises
    ------
    YAMLError
        If it is no YAML, a mapping has a key twice, or an alias is used.
    ValueError, OverflowError, RecursionError
        For values that cannot be, such as dates that do not exist.
    """
    return yaml.load(text, _Loader)  # noqa: S506  a safe loader


def yaml_node(text: str) -> Node | None:
    """Return the root of YAML text, which knows where in it everything stands; errors as above."""
    return yaml.compose(text, _Loader)


def yaml_number(value: float, digits: int = 4) -> str:
    """Return `value` as YAML text that ROS 2 and YAML 1.1 both take for a floating-point number."""
    text = f"{value:.{digits}g}"
    mantissa, exponent, power = text.partition("e")
    if "." not in mantissa:
        mantissa += ".0"
    return f"{mantissa}e{int(power):+d}" if exponent else mantissa


def yaml_string(text: str) -> str:
    """Return `text` as YAML takes it for text, quoted only where it has to be."""
    dumped: str = yaml.safe_dump(text, default_flow_style=True, allow_unicode=True, width=10_000)
    return dumped.splitlines()[0]
