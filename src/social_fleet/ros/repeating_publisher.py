"""A topic that is latched per key: a late subscriber gets the last message of every key, not only the last of all."""

import threading
from typing import Any, Callable, Dict, Hashable

import genpy
import rospy


class RepeatingPublisher(rospy.SubscribeListener):
    """Publishes messages under keys, and all of them again to each new subscriber.

    Parameters
    ----------
    topic, kind
        As of `rospy.Publisher`.
    """

    def __init__(self, topic: str, kind: Any) -> None:
        super().__init__()
        self._lock = threading.RLock()  # rospy does not guard a message to one subscriber against one to all
        self._last: Dict[Hashable, genpy.Message] = {}
        self._publisher = rospy.Publisher(topic, kind, queue_size=1000, subscriber_listener=self)

    def publish(self, messages: Dict[Any, genpy.Message], *, replace: bool = False) -> None:
        """Send `messages` and remember them beside the earlier ones, or instead of these."""
        with self._lock:
            if replace:
                self._last.clear()
            self._last.update(messages)
            for message in messages.values():
                self._publisher.publish(message)

    def repeat(self, key: Hashable) -> None:
        """Send the last message of `key` to everybody again."""
        with self._lock:
            if key in self._last:
                self._publisher.publish(self._last[key])

    def last(self, key: Hashable) -> Any:
        """The last message of `key`; None when there is none."""
        with self._lock:
            return self._last.get(key)

    def peer_subscribe(self, topic_name: str, topic_publish: Callable, peer_publish: Callable) -> None:
        """Called by rospy with a new subscriber."""
        with self._lock:
            for message in self._last.values():
                peer_publish(message)
