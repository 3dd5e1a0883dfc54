"""What is known about a result, for the panel."""

from __future__ import annotations

from typing import Any

from .messages import LEVELS, counted, reason_text, severity

_WORST = 5


def store(outcome: Any, obj: Any, results: dict[str, Any], names: dict[str, dict[str, str]], messages: list[str]) -> int:
    """Keeps verdict, worst poses and messages with the scene; the number of poses.

    `names` has the shape key of each pose, for each kind of poses.
    """
    outcome.target = obj
    outcome.messages.clear()
    outcome.worst.clear()
    levels, poses, told = [], [], list(messages)
    for kind, result in results.items():
        levels.append(result.verdict or "good")
        told += [text for text in result.warnings if text not in told]
        told += [f"left out: {diagnostic.message}" for diagnostic in result.failed]
        for pose in result.report.get("poses", []):
            if pose["name"] in names[kind]:
                poses.append((kind, pose["name"], pose.get("verdict") or {}))
    outcome.verdict = max(levels, key=LEVELS.index, default="good")
    count = sum(len(result.poses) for result in results.values())
    doubtful = sum(severity(verdict)[0] > 0 for _, _, verdict in poses)
    outcome.summary = f"{counted(count, 'pose')}, {doubtful} of them to look at" if doubtful else counted(count, "pose")
    for kind, name, verdict in sorted(poses, key=lambda pose: severity(pose[2]), reverse=True)[:_WORST]:
        if severity(verdict)[0] == 0:
            break
        row = outcome.worst.add()
        row.key = names[kind][name]
        row.is_frame = kind == "frames"
        row.frame = int(name) if row.is_frame else 0
        row.level = verdict["level"]
        row.reason = reason_text(verdict)
    for text in told:
        outcome.messages.add().text = text
    return count
