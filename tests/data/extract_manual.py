"""Extract the functions of manual 3.8, sections 1.3.1 to 1.3.16, into manual-3.8.json.

    python tests/data/extract_manual.py <the manual as Markdown>            write the data
    python tests/data/extract_manual.py <the manual as Markdown> --check    compare with it

The manual is not part of this project. Prototypes, ranges, units, lengths, choices and defaults
are read from its text by the patterns below; `manual_words.py` holds what no pattern can find:
the meanings in English, and the corrections, each with its reason.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
from pathlib import Path
from typing import Any

import thriftpy2
from manual_words import (
    CORRECTIONS,
    MEANINGS,
    NOT_ON_WIRE,
    NOT_SENT,
    NOTES,
    SPELLINGS,
    WIRE_NAMES,
)

HERE = Path(__file__).resolve().parent
DATA = HERE / "manual-3.8.json"
IDL = HERE.parents[1] / "idl" / "robot.thrift"

HEADING = r"(?:\*\*|#{4} )?{}\s*[:：]?\s*(?:\*\*)?\s*$"
PROTOTYPE = re.compile(
    r"(?:```\n(?P<block>[^`]*?)```|^[`*](?P<inline>\w+ ?\([^`*]*?\)) ?[`*])\s*\n+(?:---\s*\n+)?"
    r"(?=(?:\*\*|#{4} )?函数说明)",
    re.MULTILINE,
)
NUMBER = r"[-+]?(?:[\d.]+|∞)?(?:\*?PI)?(?:/\d+)?"
RANGE = re.compile(rf"([\[(])({NUMBER}),({NUMBER})([\])])")
#: "1-16", "1~100", "0-65535" after a word for a range, or after "%, "
SPAN = re.compile(r"(?:范围为?从?|范围[:：]|取值为|单位[:：]%,)(\d+)[-~](\d+)")
#: "m", "(rad/s)", "m/s, rad/s", "(N/(m/s))", "kg*m²"
_ONE = r"(?:mA|ms|m|rad|s|kg|Nm|N|Hz|V|%)(?:[./*](?:[A-Za-z]+[²2]?|\([a-z/]+\)))*(?![A-Za-z])"
UNIT = re.compile(rf"单位(?:为)?[:：]?\(?({_ONE}(?:[,、或]{_ONE})*)")
SAME_UNITS = {"m/rad": "m, rad", "m/s2": "m/s²", "N.m": "N·m", "Nm": "N·m"}
BLOCKS = re.compile(r"默认(?:为|值)?阻塞")
LEFT_OUT = "缺省"
DEFAULT = re.compile(r"默认(?:值)?(?:为)?(-?\d+(?:\.\d+)?|true|false)(?=Hz|s|表示|[,.、;]|$)")
CHOICE = re.compile(r"(?<![A-Za-z0-9-])(?:mode=)?(-?\d)(?:[:：]|为(?!与)|位参|代表|基于)")
COUNTS = (
    (re.compile(r"(?:最多不超过)(\d+)个点"), "max_points"),
    (re.compile(r"最长不超过(\d+)个字节"), "max_bytes"),
    (re.compile(r"必须为(\d+)个"), "length"),
    (re.compile(r"^(\d+)(?:个(?:笛卡尔|末端)|自由度)"), "length"),
    (re.compile(r"1-(\d)(?:关节|轴)"), "length"),
)
#: "[mass, x_cog, y_cog, z_cog]"
COMPONENTS = re.compile(r"[\[{]([A-Za-z]\w*(?:,[A-Za-z]\w*){2,})[\]}]")


def plain(text: str) -> str:
    """Markdown and the formulas in it as plain text."""
    for old, new in (
        (r"\_", "_"),
        (r"\*", "*"),
        ("R_", "R"),
        (r"\infty", "∞"),
        (r"\cdot", "*"),
        (r"\pi", "PI"),
        (r"\text{kg}", "kg"),
        (r"\text{m}", "m"),
        (r"\text{PI}", "PI"),
        ("^2", "²"),
        ("<sup>2</sup>", "²"),
        ("$", ""),
        ("`", ""),
        ("**", ""),
    ):
        text = text.replace(old, new)
    return re.sub(r"\*(true|false)\*", r"\1", text)


def squeezed(text: str) -> str:
    """Without spaces, and with the half-width forms of punctuation."""
    text = re.sub(r"\s+", "", text)
    return text.translate(str.maketrans("，。；（）", ",.;()"))


def value(expression: str) -> float | None:
    """A bound as a number; None where it is infinite."""
    if "∞" in expression:
        return None
    factors, _, divisor = expression.partition("/")
    result = 1.0
    for factor in factors.split("*"):
        sign = -1.0 if factor.startswith("-") else 1.0
        word = factor.lstrip("+-")
        result *= sign * (math.pi if word == "PI" else float(word))
    return result / float(divisor) if divisor else result


def split_arguments(text: str) -> list[str]:
    parts, depth, current = [], 0, ""
    for char in text:
        depth += (char in "<{") - (char in ">}")
        if char == "," and depth == 0:
            parts.append(current)
            current = ""
        else:
            current += char
    return [part for part in [*parts, current] if part.strip()]


def prototype(text: str) -> tuple[str, list[dict[str, Any]]]:
    """Name and parameters of a prototype."""
    name, _, rest = text.partition("(")
    found = []
    for argument in split_arguments(rest.strip().removesuffix(")")):
        typed, _, default = argument.replace("op _", "op_").partition("=")
        match = re.fullmatch(r"(.*?)[\s&:]*(\w+)\s*", typed.strip())
        assert match is not None, argument
        kind = re.sub(r"std::|const|&|\s", "", match[1])
        entry: dict[str, Any] = {"name": match[2], "type": kind}
        if default.strip():
            entry["prototype_default"] = default.strip()
        found.append(entry)
    return name.strip(), found


def described(text: str) -> dict[str, str]:
    """The description of each parameter, by the name that stands before the colon."""
    found: dict[str, str] = {}
    name = ""
    for raw in text.splitlines():
        line = plain(raw).strip()
        if not line or line == "---":
            continue
        match = re.match(r"\*?([A-Za-z_]\w*)\*?\s*[:：]+\s*(.*)", line)
        match = match or re.match(r"(p\d) (.*)", line)
        if match:
            name, line = match[1], match[2]
        if name:
            found[name] = found.get(name, "") + line
    return found


def subject(before: str) -> str:
    """What a range speaks of, by the words before it."""
    for words, meaning in (
        ("线速度范围", "linear"),
        ("方向速度范围", "angular" if "RX" in before[-20:] else "linear"),
        ("角速度范围", "angular"),
        ("Rx、Ry、Rz", "rotation"),
        ("质量范围", "mass"),
    ):
        if words in before[-30:]:
            return meaning
    return "value"


def unit_names(text: str) -> list[str]:
    """Units as this project writes them."""
    names = [one.replace("*", "·") for one in re.split("[,、]", text.replace("或", " or "))]
    for old, new in SAME_UNITS.items():
        names = [new if name == old else name.replace("Nm/", "N·m/") for name in names]
    return names


def facts(text: str) -> dict[str, Any]:
    """What patterns find in a parameter's description."""
    text = squeezed(text)
    found: dict[str, Any] = {}
    ranges = [
        {
            "of": subject(text[: match.start()]),
            "low": value(match[2]),
            "high": value(match[3]),
            "low_open": match[1] == "(",
            # the manual closes the bracket at infinity too
            "high_open": match[4] == ")",
        }
        for match in RANGE.finditer(text)
        if match[2] and match[3]
    ]
    ranges += [
        {"of": "value", "low": int(m[1]), "high": int(m[2]), "low_open": False, "high_open": False}
        for m in SPAN.finditer(text)
    ]
    if ranges:
        found["ranges"] = ranges
    if units := [unit for match in UNIT.finditer(text) for unit in unit_names(match[1])]:
        found["unit"] = ", ".join(dict.fromkeys(units))
    for pattern, key in COUNTS:
        if match := pattern.search(text):
            found[key] = int(match[1])
    if match := COMPONENTS.search(text):
        found["length"] = match[1].count(",") + 1
    elif "三维" in text:
        found["length"] = 3
    if match := DEFAULT.search(text):
        found["default"] = json.loads(match[1])
    elif BLOCKS.search(text):
        found["default"] = True
    choices = sorted({int(match[1]) for match in CHOICE.finditer(text)})
    if len(choices) > 1:
        found["choices"] = choices
    return found


def returns(text: str) -> str:
    """What is returned, as one of a few kinds."""
    text = squeezed(plain(text).replace("*", ""))
    if "任务的id" in text and "结束时" in text:
        return "end state if it blocks, else task id"
    if "id" in text:
        return "task id"
    if "结束时" in text:
        return "end state"
    if text.startswith("无") or not text:
        return "nothing"
    return "value"


def wire_functions() -> dict[str, list[str]]:
    module = thriftpy2.load(str(IDL), module_name="manual_extract_thrift")
    service = module.RPCRobot
    return {
        name: [entry[1] for entry in getattr(service, f"{name}_args").thrift_spec.values()]
        for name in service.thrift_services
    }


def function(section: str, proto: str, body: str, wire: dict[str, list[str]]) -> dict[str, Any]:
    """One function of the manual."""
    name, parameters = prototype(proto)
    wire_name = None if name in NOT_ON_WIRE else WIRE_NAMES.get(name, (name, ""))[0]
    names = wire[wire_name] if wire_name else []
    parts = re.split(HEADING.replace("{}", "(参数说明|返回值)"), body, flags=re.MULTILINE)
    # a struct's listing may follow with a heading of its own: the first of each counts
    texts = dict(reversed(list(zip(parts[1::2], parts[2::2], strict=True))))
    about = described(texts.get("参数说明", ""))
    for parameter in parameters:
        own = parameter["name"]
        key = f"{name}.{own}"
        spellings = (own, *SPELLINGS.get(key, SPELLINGS.get(own, ())))
        parameter["wire"] = next((n for n in spellings if n in names), None)
        said = next((about[n] for n in spellings if n in about), "")
        parameter["optional"] = LEFT_OUT in said or "prototype_default" in parameter
        parameter.update(facts(said))
        if wire_name and parameter["wire"] is None and key not in NOT_SENT:
            parameter["out"] = True  # the wire returns it
        parameter["meaning"] = MEANINGS.get(key, MEANINGS.get(own, ""))
        if key in CORRECTIONS:
            changes, reason = CORRECTIONS[key]
            parameter.update(changes)
            parameter["corrected"] = reason
    mark_optional(parameters)
    result: dict[str, Any] = {
        "section": section,
        "name": name,
        "wire": wire_name,
        "prototype": proto,
        "parameters": parameters,
        "returns": returns(texts.get("返回值", "").split("```")[0]),
    }
    if any(parameter.get("out") for parameter in parameters):
        result["returns"] = "value, in the parameter marked out"
    if name in WIRE_NAMES:
        result["wire_reason"] = WIRE_NAMES[name][1]
    if name in NOT_ON_WIRE:
        result["wire_reason"] = NOT_ON_WIRE[name]
    if name in NOTES:
        result["notes"] = NOTES[name]
    return result


def mark_optional(parameters: list[dict[str, Any]]) -> None:
    """Leave "optional" on the parameters that a call may leave out.

    They are those with a default in the prototype, those that the text says may be left out, and
    those with a default in the text that no other parameter has to follow.
    """
    last = True
    for parameter in reversed(parameters):
        optional = parameter.pop("optional") or (last and "default" in parameter)
        last = last and optional
        if optional:
            parameter["optional"] = True


def extract(text: str) -> dict[str, Any]:
    """All functions of the manual's text."""
    text = text[text.index("## 1.3 函数说明") : text.index("## 1.4 Visual")].replace("\\_", "_")
    wire = wire_functions()
    sections = re.split(r"^### (1\.3\.\d+) (.*)$", text, flags=re.MULTILINE)
    found: list[dict[str, Any]] = []
    titles: dict[str, str] = {}
    for section, title, body in zip(sections[1::3], sections[2::3], sections[3::3], strict=True):
        titles[section] = title.strip()
        matches = list(PROTOTYPE.finditer(body))
        ends = [match.start() for match in matches[1:]] + [len(body)]
        for match, end in zip(matches, ends, strict=True):
            proto = " ".join((match["block"] or match["inline"]).split())
            found.append(function(section, proto, body[match.end() : end], wire))
    unused = set(CORRECTIONS) - {f"{f['name']}.{p['name']}" for f in found for p in f["parameters"]}
    assert not unused, f"corrections of parameters that are not there: {unused}"
    return {
        "source": "DUCO secondary development manual 3.8, sections 1.3.1 to 1.3.16",
        "sections": titles,
        "functions": found,
    }


def dumped(data: dict[str, Any]) -> str:
    """As JSON with a line for each parameter, so that a difference is easy to see."""

    def line(part: object) -> str:
        return json.dumps(part, ensure_ascii=False)

    blocks = []
    for entry in data["functions"]:
        lines = []
        for key, part in entry.items():
            if key == "parameters" and part:
                rows = ",\n".join(f"    {line(parameter)}" for parameter in part)
                lines.append(f'   "parameters": [\n{rows}\n   ]')
            else:
                lines.append(f"   {line(key)}: {line(part)}")
        blocks.append("  {\n" + ",\n".join(lines) + "\n  }")
    head = ",\n".join(f" {line(k)}: {line(v)}" for k, v in data.items() if k != "functions")
    return "{\n" + head + ',\n "functions": [\n' + ",\n".join(blocks) + "\n ]\n}\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("manual", type=Path, help="the manual as Markdown")
    parser.add_argument("--check", action="store_true", help="fail if the data is out of date")
    options = parser.parse_args()
    data = extract(options.manual.read_text(encoding="utf-8"))
    text = dumped(data)
    assert json.loads(text) == data
    if not options.check:
        DATA.write_text(text, encoding="utf-8")
        return 0
    return 0 if DATA.read_text(encoding="utf-8") == text else 1


if __name__ == "__main__":
    sys.exit(main())
