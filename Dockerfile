# docker build -t heyoka_bike .                            scores, diagnoses, verifies, proves
# docker build -t heyoka_bike:generate --target generate . integrates too
# docker build -t heyoka_bike:serve --target serve .       a page to drop files on
# docker run --rm -v "$PWD:/data" heyoka_bike score my-results.txt -o report.html
# docker run --rm -p 127.0.0.1:8000:8000 heyoka_bike:serve
FROM python:3.12-slim AS build
WORKDIR /source
COPY . .
RUN pip wheel --no-cache-dir --no-deps --wheel-dir /wheels .

FROM python:3.12-slim AS generate
COPY constraints.txt /etc/heyoka_bike-constraints.txt
RUN --mount=type=bind,from=build,source=/wheels,target=/wheels \
    wheel=$(echo /wheels/*.whl) && \
    pip install --no-cache-dir -c /etc/heyoka_bike-constraints.txt "${wheel}[generate,plot]"
RUN useradd --uid 1000 --create-home user
USER 1000
WORKDIR /data
ENTRYPOINT ["heyoka-bike"]
CMD ["--help"]

FROM python:3.12-slim AS serve
COPY constraints.txt /etc/heyoka_bike-constraints.txt
RUN --mount=type=bind,from=build,source=/wheels,target=/wheels \
    wheel=$(echo /wheels/*.whl) && \
    pip install --no-cache-dir -c /etc/heyoka_bike-constraints.txt "${wheel}[serve]"
RUN useradd --uid 1000 --create-home user
USER 1000
EXPOSE 8000
HEALTHCHECK CMD ["python", "-c", "from urllib.request import urlopen; urlopen('http://127.0.0.1:8000/health', timeout=5)"]
ENTRYPOINT ["heyoka-bike", "serve", "--host", "0.0.0.0"]
# The names by which browsers ask for it; without heyoka a diagnosis takes three times as long.
CMD ["--name", "localhost", "--name", "127.0.0.1", "--no-diagnose"]

# The last one is built by default.
FROM python:3.12-slim AS score
COPY constraints.txt /etc/heyoka_bike-constraints.txt
RUN --mount=type=bind,from=build,source=/wheels,target=/wheels \
    pip install --no-cache-dir -c /etc/heyoka_bike-constraints.txt /wheels/*.whl
RUN useradd --uid 1000 --create-home user
USER 1000
WORKDIR /data
ENTRYPOINT ["heyoka-bike"]
CMD ["--help"]
