"""A drive's YAML from a few answers, so that nobody has to write the first one by hand."""

from belt_ros.starter.answers import QUESTIONS, Answers, answers_from
from belt_ros.starter.question import Question
from belt_ros.starter.text import drive_yaml

__all__ = ["QUESTIONS", "Answers", "Question", "answers_from", "drive_yaml"]
