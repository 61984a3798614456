"""What people read and open names the topics that there are."""

from __future__ import annotations

import json
import re
from pathlib import Path

from ruamel.yaml import YAML

from cloth_sim_ros import interfaces
from cloth_sim_ros.interface_table import as_page
from cloth_sim_ros.parameters import parameter_names

CHECKOUT = Path(__file__).parents[2]
TYPES = {i.name.replace("~", "/cloth_sim"): i.type_name for i in interfaces.OUTPUTS}


def test_the_page_is_the_generated_one_and_holds_everything():
    page = (CHECKOUT / "docs" / "interfaces.md").read_text()
    assert page == as_page(), "run: python -m cloth_sim_ros.interface_table > docs/interfaces.md"
    for interface in interfaces.INTERFACES:
        assert f"`{interface.name.replace('{name}', '<name>')}`" in page
    for name in parameter_names():
        assert f"| `{name}` |" in page


def test_the_rviz_layout_shows_topics_that_there_are_in_displays_that_fit_them():
    layout = YAML(typ="safe", pure=True).load((CHECKOUT / "config" / "cloth.rviz").read_text())
    manager = layout["Visualization Manager"]
    shown = {d["Topic"]["Value"]: d for d in manager["Displays"] if "Topic" in d}
    assert {"/cloth_sim/cloth/mesh", "/cloth_sim/obstacles"} <= set(shown)
    for topic, display in shown.items():
        assert TYPES[topic].rpartition("/")[2] == display["Class"].rpartition("/")[2]
        reliability = display["Topic"]["Reliability Policy"].lower()
        durability = display["Topic"]["Durability Policy"].lower().replace(" ", "_")
        offered = next(i.qos for i in interfaces.OUTPUTS if i.name.replace("~", "/cloth_sim") == topic)
        assert (reliability, durability) == (offered.reliability, offered.durability)
    assert manager["Global Options"]["Fixed Frame"] == "world"


def test_the_foxglove_layout_shows_topics_that_there_are():
    text = (CHECKOUT / "config" / "foxglove.json").read_text()
    layout = json.loads(text)
    topics = {re.sub(r"\.data$", "", name) for name in re.findall(r'"(/[a-z_/]+(?:\.data)?)"', text)}
    assert topics <= set(TYPES)
    assert {"/cloth_sim/cloth/mesh", "/cloth_sim/obstacles", "/diagnostics"} <= topics
    plotted = set(re.findall(r'"(/[a-z_/]+)\.data"', text))
    assert plotted and {TYPES[name] for name in plotted} == {"std_msgs/msg/Float64"}
    drawn = {TYPES[name].rpartition("/")[2] for name in layout["configById"]["3D!cloth"]["topics"]}
    assert drawn == {"Marker", "MarkerArray", "PointCloud2"}
    assert TYPES[layout["configById"]["DiagnosticSummary!cloth"]["topicToRender"]].endswith("/DiagnosticArray")
    panels = set(re.findall(r'"(?:first|second)": "([^"]+)"', text))
    assert panels == set(layout["configById"])
