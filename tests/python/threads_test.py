"""Python's lock is given up, and threads do not get into each other's way."""

import sys
import threading
import unittest

import numpy as np

import cylpose
import scene


class Lock(unittest.TestCase):
    def setUp(self):
        # No thread is made to give up the lock: another one runs only when it is given up on purpose.
        self.addCleanup(sys.setswitchinterval, sys.getswitchinterval())
        sys.setswitchinterval(1000)

    def assert_lets_others_run(self, call):
        ran = []
        go = threading.Lock()
        go.acquire()

        def other():
            with go:
                ran.append(True)

        thread = threading.Thread(target=other)
        thread.start()
        go.release()  # from now on it waits for Python's lock alone
        for _ in range(5000):
            if ran:
                break
            call()
        self.assertTrue(ran)
        thread.join()

    def test_without_calls_nobody_else_runs(self):
        with self.assertRaises(AssertionError):
            self.assert_lets_others_run(lambda: None)

    def test_while_estimating(self):
        image, _, _ = scene.small_view()
        estimator = scene.small_estimator()
        self.assert_lets_others_run(lambda: estimator.estimate(image))

    def test_while_waiting_for_a_result(self):
        # Were the lock held in next, the frame would never be put.
        image, camera, parts = scene.small_view()
        pipeline = cylpose.Pipeline(camera, parts, backend="serial")
        putter = threading.Thread(target=lambda: (pipeline.put(image, 0), pipeline.finish()))
        putter.start()
        self.assertEqual(sum(1 for _ in pipeline), 1)
        putter.join()


class TwoThreads(unittest.TestCase):
    def results_of_two(self, estimators):
        image, _, _ = scene.small_view()
        start = threading.Barrier(2)
        results = [[], []]

        def work(own, estimator):
            start.wait()
            for _ in range(100):
                own.append(estimator.estimate(image))

        workers = [threading.Thread(target=work, args=pair) for pair in zip(results, estimators)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        return results

    def test_with_an_estimator_each(self):
        image, _, _ = scene.small_view()
        alone = scene.small_estimator()
        expected = [alone.estimate(image) for _ in range(100)]
        for own in self.results_of_two([scene.small_estimator(), scene.small_estimator()]):
            self.assertEqual(len(own), 100)
            for result, wanted in zip(own, expected):
                self.assertEqual(result.searched, wanted.searched)
                np.testing.assert_array_equal(result.parts[0].covariance, wanted.parts[0].covariance)

    def test_with_one_estimator(self):
        estimator = scene.small_estimator()
        one, other = self.results_of_two([estimator, estimator])
        self.assertEqual(sorted(result.frame for result in one + other), list(range(200)))
        self.assertEqual({result.parts[0].status.value for result in one + other}, {"ok"})


if __name__ == "__main__":
    unittest.main()
